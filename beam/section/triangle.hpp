// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "beam/section/solver.hpp"

/// The six-node triangle of the section solver (solver.hpp has the equations).
namespace flexura::beam {

using Matrix6x18 = Eigen::Matrix<double, 6, 18>;
using MatrixX6 = Eigen::Matrix<double, Eigen::Dynamic, 6>;

struct QuadraturePoint {
  double r, s, weight;
};

/// Seven points, exact to degree 5 (J. Radon, Monatsh. Math. Phys. 52 (1948)): integrands of straight-sided
/// triangles have degree 4.
const std::array<QuadraturePoint, 7>& triangle_quadrature();

/// Where a triangle is looked at: shape functions, their derivatives in y and z, the place, the area measure.
struct Place {
  Eigen::Matrix<double, 6, 1> N;
  Eigen::Matrix<double, 6, 2> dN;
  double y, z, det;
};

Place place_in(const SectionMesh& mesh, int cell, double r, double s);

/// Strains of nodal warpings (B across, S along) and of the rigid section (Phi), order xx, yy, zz, yz, xz,
/// xy.
struct Operators {
  Matrix6x18 B = Matrix6x18::Zero(), S = Matrix6x18::Zero();
  Matrix6d Phi = Matrix6d::Zero();
};

Operators operators_at(const Place& place);

}  // namespace flexura::beam
