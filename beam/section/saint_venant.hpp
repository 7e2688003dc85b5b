// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "beam/section/triangle.hpp"

namespace flexura::beam {

/// Solution of the Saint-Venant problems (solver.hpp), one column for each resultant.
struct SaintVenantFields {
  MatrixX6 X, X_1;  ///< 3 n x 6: warping of each node
  Matrix6d Y, Y_1;  ///< strains of the axis
  Matrix6d f;       ///< flexibility
};

/// `Q_of_cell`: the material's 6x6 stiffness in each triangle.
SaintVenantFields solve_saint_venant(const std::string& name, const SectionMesh& mesh,
                                     const std::vector<Matrix6d>& Q_of_cell);

}  // namespace flexura::beam
