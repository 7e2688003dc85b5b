// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "reduce/assembly/input/part.hpp"

/// The six motions of all nodes of a mesh.
namespace flexura::reduce {

struct NodeMotions {
  enum class Rotation : std::int8_t {
    unknown,  ///< zero in T: nothing of the mesh turns with the node
    own,      ///< a dof of the finite element model
    curl,     ///< half the curl of the displacements
  };
  std::vector<mesh::Index> nodes;   ///< n_k, ascending
  std::vector<Rotation> rotations;  ///< n_k
  Eigen::MatrixXd T;  ///< 6 n_k x n: (u, theta) of the first, then of the second, ... [m, rad per unit]
};

/// The nodes that the mesh came with: without the points that followers, skins and masses add to it.
std::vector<mesh::Index> nodes_of_mesh(const Part& part);

/// Of displacements T (3 n_nodes x n), with `rotations` of the nodes that turn (rotation_of[node] is a node's place among them,
/// -1: it has none; both may be empty).  Elsewhere theta = rot u / 2, the mean over the solids that share the node, each at
/// the node itself; a cell that is degenerate there has no say.
NodeMotions node_motions(const Part& part, const Eigen::MatrixXd& T, const Eigen::MatrixXd& rotations = {},
                         const std::vector<int>& rotation_of = {});

}  // namespace flexura::reduce
