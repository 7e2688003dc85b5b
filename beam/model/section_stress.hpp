// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "beam/model/mesh.hpp"

namespace flexura::beam {

/// Stresses at a point of a section, in the member's axes [Pa].
struct PointStress {
  std::string name;
  double y = 0.0, z = 0.0;  ///< [m]
  double sigma_xx = 0.0, tau_xy = 0.0, tau_xz = 0.0;
  double von_mises() const;
};

/// At the stress points of a member's section at x (for tapers that of the section there) under resultants
/// (N, V_y, V_z, T, M_y, M_z).  Empty where the section knows none (General Basic and Advanced, Matrix
/// Input).
std::vector<PointStress> section_stresses(const BeamMesh& mesh, int member, double x,
                                          const Vector6d& resultants);

}  // namespace flexura::beam
