// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
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
  elastic,  ///< like `average`, but the set's own deformation is reduced to interface modes
            ///< (reduce/cms/interface_modes.hpp)
};

/// "rigid", "average", "node", "elastic".
const char* name_of(Tie tie);

/// An interface: the place at which joints and forces will hold the body.
struct InterfaceSpec {
  std::string name;
  Tie tie = Tie::rigid;
  Eigen::Vector3d point =
      Eigen::Vector3d::Zero();  ///< p_BoN_B [m]; for Tie::node the node's own place is taken
  mesh::NodeSet set;            ///< faces give the area weights of averages; none: equal weights
  std::vector<int> directions = {0, 1, 2,
                                 3, 4, 5};  ///< retained: 0-2 displacement x, y, z, 3-5 rotation; ascending
  std::vector<double> weights = {};         ///< Tie::average: of each node of the set, instead of areas
};

/// A rigid piece of mass: on a node of the mesh or on an interface node (point_mass.hpp).
struct PointMass {
  mesh::Index node = -1;
  double mass = 0.0;                                  ///< [kg]
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();   ///< from the node to the mass centre [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the mass centre [kg m^2]
};

/// Mass that moves with a node.
struct NodalMass {
  mesh::Index node = -1;
  double mass = 0.0;  ///< [kg]
};

/// A spring and a damper between two nodes, along the line that joins them; where they lie at the same place,
/// alike in all directions.  Either way a rigid motion of the body does not strain it.
struct Link {
  std::string name;
  mesh::Index from = -1, to = -1;
  double stiffness = 0.0;  ///< [N/m]
  double damping = 0.0;    ///< [N s/m]
};

/// Stiffness and mass that another program assembled, by pairs of nodes (from <= to), instead of cells.
struct NodalMatrices {
  std::vector<std::array<mesh::Index, 2>> pairs;
  std::vector<Eigen::Matrix3d> K;  ///< of each pair [N/m], rows of the first node
  std::vector<double> m;           ///< of each pair: the mass matrix is m (x) I_3 [kg]
};

/// Everything that a reduction starts from.
struct Part {
  mesh::Mesh mesh;
  std::vector<Material> materials;  ///< CellBlock::material points here
  std::vector<InterfaceSpec> interfaces;
  std::optional<NodalMatrices> matrices;  ///< instead of what the cells and materials give
  std::vector<NodalMass> masses;
  std::vector<Link> links;
  MassKind mass = MassKind::consistent;
  Formulation formulation = Formulation::standard;
};

}  // namespace flexura::reduce
