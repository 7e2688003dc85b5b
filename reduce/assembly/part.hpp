// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mesh/model/mesh.hpp"
#include "reduce/elements/material.hpp"
#include "reduce/elements/solid.hpp"

namespace flexura::reduce {

/// How an interface node is tied to the nodes of its set.
enum class Tie {
  rigid,    ///< RBE2: the set follows the interface node as a rigid body, u_a = u + theta x (x_a - x)
  average,  ///< RBE3: the interface node follows the set, as its least-squares (area-weighted) mean motion
  node,     ///< the interface node is one node of the mesh, translations only
};

/// "rigid", "average", "node".
const char* name_of(Tie tie);

/// An interface: the place at which joints and forces will hold the body.
struct InterfaceSpec {
  std::string name;
  Tie tie = Tie::rigid;
  Eigen::Vector3d point =
      Eigen::Vector3d::Zero();  ///< p_BoN_B [m]; for Tie::node the node's own place is taken
  mesh::NodeSet set;            ///< faces give the area weights of Tie::average; none: equal weights
  std::vector<int> directions = {0, 1, 2,
                                 3, 4, 5};  ///< retained: 0-2 displacement x, y, z, 3-5 rotation; ascending
};

/// Everything that a reduction starts from.
struct Part {
  mesh::Mesh mesh;
  std::vector<Material> materials;  ///< CellBlock::material points here
  std::vector<InterfaceSpec> interfaces;
  MassKind mass = MassKind::consistent;
  Formulation formulation = Formulation::standard;
};

}  // namespace flexura::reduce
