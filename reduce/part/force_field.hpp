// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "mesh/model/mesh.hpp"

namespace flexura::reduce {

/// A force field of a load case: force per mass [N/kg] at each node (n x 3) by one formula of x, y, z [m] and
/// pi for each direction.  Throws std::invalid_argument: a formula that cannot be read, a value that is not
/// finite.
Eigen::MatrixX3d evaluate_field(const std::array<std::string, 3>& formulas, const mesh::Mesh& mesh);

/// One formula of x, y, z [m] in the middle of the nodes of each solid cell, in the order of their blocks.
Eigen::VectorXd evaluate_at_cells(const std::string& formula, const mesh::Mesh& mesh);

}  // namespace flexura::reduce
