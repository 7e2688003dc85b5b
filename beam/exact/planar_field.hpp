// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "beam/exact/strain_field.hpp"
#include "beam/section/section.hpp"

/// The strain fields of strain_field.hpp in the plane of the section's x and y: (gamma_x, gamma_y, kappa_z) alone.
namespace flexura::beam::exact {

/// Strains at x are (first + x slope) s.
struct PlanarField {
  static constexpr int kMost =
      5;  ///< coordinates: beam 5 (N, V_y, M_z, and slopes of N and M_z), rod 2, cable 2
  Eigen::Matrix<double, 3, Eigen::Dynamic> first, slope;
  Eigen::MatrixXd K;  ///< n x n [N m]

  int n() const { return static_cast<int>(first.cols()); }
};

/// What keeps a section with the stiffness C and the mass distribution from bending in its x-y plane alone, in words; empty
/// where nothing does: C couples no strain of the plane with one across it, and the mass lies on both sides alike.
const char* why_not_planar(const Matrix6d& C, const SectionInertia& inertia);

/// As strain_field(), of which it has what stays in the plane.  Throws std::invalid_argument.
PlanarField planar_field(Kind kind, const Matrix6d& C, double l);

}  // namespace flexura::beam::exact
