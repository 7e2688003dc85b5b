// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <compare>
#include <optional>
#include <string>
#include <utility>
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
            ///< (reduce/cms/shapes/interface_modes.hpp)
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
  bool rotations = true;          ///< Tie::rigid: the set's own rotations (of shells and beams) follow, too
  mesh::Index turning_node = -1;  ///< the one whose rotation follows even so
};

/// A rigid piece of mass: on a node of the mesh or on an interface node (point_mass.hpp).
struct PointMass {
  mesh::Index node = -1;
  double mass = 0.0;                                  ///< [kg]
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();   ///< from the node to the mass centre [m]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the mass centre [kg m^2]
  double alpha = 0.0;                                 ///< [1/s], as of NodalMass
};

/// Mass that moves with a node.
struct NodalMass {
  mesh::Index node = -1;
  double mass = 0.0;   ///< [kg]
  double alpha = 0.0;  ///< [1/s] of what it is made of (MaterialDamping)
};

/// A spring and a damper between two nodes, along the line that joins them; where they lie at the same place,
/// alike in all directions.  Either way a rigid motion of the body does not strain it.
struct Link {
  std::string name;
  mesh::Index from = -1, to = -1;
  double stiffness = 0.0;  ///< [N/m]
  double damping = 0.0;    ///< [N s/m]
};

/// Stiffness, mass and damping that another program assembled, by pairs of nodes (from <= to), instead of cells.
struct NodalMatrices {
  std::vector<std::array<mesh::Index, 2>> pairs;
  std::vector<Eigen::Matrix3d> K;       ///< of each pair [N/m], rows of the first node
  std::vector<double> m;                ///< of each pair: the mass matrix is m (x) I_3 [kg]
  std::vector<Eigen::Matrix3d> D = {};  ///< of each pair [N s/m]; none: not given
};

/// An element of nodes with six dofs each (u, theta) whose matrix is given: a beam, a bushing, a spring.  A node
/// whose rows of theta are all zero gets no rotation from it.
struct FrameElement {
  std::vector<mesh::Index> nodes;
  Eigen::MatrixXd K;            ///< 6n x 6n, axes of B [N/m, N, N m]
  Eigen::MatrixXd D = {};       ///< 6n x 6n of a damper, alike; empty: none
  Eigen::MatrixXd K_loss = {};  ///< 6n x 6n, loss factors times stiffness; empty: none
};

/// The stress at a point on the outside of a beam, of axial force and bending: sigma = of_nodes (u, theta)(both nodes), rows
/// (xx, yy, zz, xy, yz, zx) in the axes of B [Pa].
struct BeamStress {
  mesh::Index point = -1;
  int material = 0;
  std::array<mesh::Index, 2> nodes{-1, -1};
  Eigen::Matrix<double, 6, 12> of_nodes = Eigen::Matrix<double, 6, 12>::Zero();
};

/// A beam or rod of a deck, one of `frames`, for its section forces.
struct CutBar {
  std::string name;
  std::array<mesh::Index, 2> nodes{-1, -1};
  Eigen::Matrix3d R_BE = Eigen::Matrix3d::Identity();  ///< columns: its axes
  Eigen::Vector3d p_Bo1_B = Eigen::Vector3d::Zero();   ///< its first end [m]
  double length = 0.0;
  /// Forces and moments on its ends, its axes, by (u, theta) of both nodes: 12 x 12.
  Eigen::Matrix<double, 12, 12> ends = Eigen::Matrix<double, 12, 12>::Zero();
  /// Its mass: a force at the point is one on the ends, its axes, by `on_ends`.
  struct Mass {
    mesh::Index point = -1;
    double mass = 0.0;  ///< [kg]
    Eigen::Matrix<double, 12, 3> on_ends = Eigen::Matrix<double, 12, 3>::Zero();
  };
  std::vector<Mass> masses = {};
  /// Rotation of the section at 0, l/3, 2 l/3, l by (u, theta) of both nodes, in B.
  std::array<Eigen::Matrix<double, 3, 12>, 4> turning = {};
};

/// A point of the mesh without dofs of its own, which moves with nodes that have six:
/// u = sum C (u_node, theta_node).  Points on the skins of shells, in and around beams, beside a node.
struct Follower {
  mesh::Index point = -1;
  std::vector<std::pair<mesh::Index, Eigen::Matrix<double, 3, 6>>> from;
};

/// A displacement (0 to 2, axes of B) or rotation (3 to 5) of a node.
struct NodalDof {
  mesh::Index node = -1;
  int direction = 0;
  auto operator<=>(const NodalDof&) const = default;
};

/// A dof that others give: q = sum of coefficients q(from), which are independent (constraints.hpp).  A rotation has one, with
/// the coefficient 1.
struct DependentDof {
  NodalDof dof;
  std::vector<std::pair<NodalDof, double>> from;
};

/// The points on both sides of the shells: for every cell of a block of mesh.shells and each of its corners
/// (shell_skins.hpp).
struct ShellSkins {
  using Corners = Eigen::Matrix<mesh::Index, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Corners top, bottom;  ///< top: on the side of the cell's normal
};

/// Everything that a reduction starts from.
struct Part {
  mesh::Mesh mesh;
  std::vector<Material> materials;  ///< CellBlock::material points here
  std::vector<InterfaceSpec> interfaces;
  std::optional<NodalMatrices> matrices;  ///< instead of what the cells and materials give
  std::vector<NodalMass> masses;
  std::vector<Link> links;
  std::vector<FrameElement> frames;
  std::vector<BeamStress> beam_stresses;
  std::vector<CutBar> bars;
  std::vector<ShellSkins> skins;  ///< of each block of mesh.shells, once they are made
  std::vector<Follower>
      followers;  ///< NodalMass on them (also below zero on their nodes) makes rotary inertia
  std::vector<DependentDof> dependent;  ///< by dof, ascending
  MassKind mass = MassKind::consistent;
  Formulation formulation = Formulation::standard;
};

}  // namespace flexura::reduce
