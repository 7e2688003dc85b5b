// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "reduce/assembly/input/part.hpp"

namespace flexura::reduce {

/// Displacements of nodes that no stiffness resists (across the rods of a plane truss, across a spring along its line): what
/// other programs hold at the ground (AUTOSPC) follows here the rigid motion of up to three nodes of the same piece that lie
/// far apart, so that rigid motions of the body strain nothing.  Said in `warnings`.  Before interfaces complete the part.
void hold_idle_moves(Part& part, std::vector<std::string>& warnings);

/// Stiffness of v . q of a node less what the rigid motion that the anchors have in the mean gives there: q is (u, theta) of
/// the node, v six numbers.  An element without nodes where the anchors' motion is the node's.
FrameElement following(const Part& part, mesh::Index node, const Eigen::Matrix<double, 6, 1>& v,
                       const std::vector<mesh::Index>& anchors, double stiffness);

}  // namespace flexura::reduce
