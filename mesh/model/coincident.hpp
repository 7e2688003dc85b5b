// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "mesh/model/mesh.hpp"

namespace flexura::mesh {

/// Pairs of these nodes in one place: nearer to one another than 1e-6 of all nodes' extent.  Each node comes with the first that
/// lies there, ascending.
std::vector<std::pair<Index, Index>> coincident_nodes(
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>& points,
    std::vector<Index> nodes);

}  // namespace flexura::mesh
