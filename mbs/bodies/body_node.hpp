// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mbs/base/math/spatial.hpp"
#include "mbs/superelement/superelement.hpp"

/// The places of a body that markers can sit on, as its superelement moves them:
///
///     q = (u, theta) = rows u_se
///
/// An interface is such a node as it stands.  Others follow several places at once, with r_k from their
/// centre to place k and D_k = [1, -r_k x] the displacement of place k for a rigid motion q about the centre:
///
/// - by interpolation (RBE3, Simpack's interpolation marker), the rigid motion that fits the displacements
/// u_k
///   best in the weighted mean,
///
///       q = argmin sum_k w_k |u_k - D_k q|^2 = (sum w D^T D)^-1 sum w D^T u,
///
///   whose translation is the weighted mean, as the centre is that of the weights.  A load at the node
///   spreads over the places as forces that are statically equivalent to it: the transpose of the same map.
/// - by a rigid link (RBE2), where the places are interfaces and move as one piece: the part of their motion
///   that no rigid motion gives is held at zero, ties^T u_se = 0.
/// - as a point of a straight beam between two interfaces, by the element's own shape functions: stretch and twist
///   linear along it, displacements across it by Hermite's cubics, and their slope.  So moves the axis of an
///   Euler-Bernoulli beam that no load bends between them.
namespace flexura::mbs {

struct BodyNode {
  std::string name;
  Vector3d p_BoN_B = Vector3d::Zero();
  Eigen::MatrixXd rows;       ///< 6 x n_se, (u, theta)
  Eigen::MatrixXd ties = {};  ///< n_se x k, independent; of a rigid link
  /// Of interfaces alone: loads here are loads on interfaces, for which there are stiffening terms.
  bool is_on_interfaces = true;
};

/// What a node follows: interfaces and vertices of the superelement's surface, by index.
struct NodePlaces {
  std::vector<int> interfaces, vertices;
  std::vector<double> weights;  ///< of the interfaces, then of the vertices; empty: all equal
};

BodyNode interface_node(const superelement::Superelement& se, int interface);
std::vector<BodyNode> interface_nodes(const superelement::Superelement& se);

/// The centre of the places by their weights, in B.
Vector3d centre_of(const superelement::Superelement& se, const NodePlaces& places);

/// By interpolation.  Vertices need the superelement's surface and shapes.  Throws std::invalid_argument
/// where the displacements of the places leave a rigid motion open: fewer than three, or all on one line.
BodyNode interpolated_node(const superelement::Superelement& se, const std::string& name,
                           const NodePlaces& places);

/// By a rigid link between interfaces.  Throws std::invalid_argument where their directions do not determine
/// the node's motion.
BodyNode rigidly_linked_node(const superelement::Superelement& se, const std::string& name,
                             const std::vector<int>& interfaces);

/// At `point` (in B), carried along by the axis between the interfaces i and j.  Throws std::invalid_argument where the point
/// does not lie between them or one of them does not keep all six directions.
BodyNode beam_node(const superelement::Superelement& se, const std::string& name, int i, int j,
                   const Vector3d& point);

/// At a vertex of the surface, with its displacement and, as it has no other, the turn of the body's frame.
BodyNode surface_node(const superelement::Superelement& se, const std::string& name, int vertex);

/// n_se x 6: the loads p_se of unit wrenches (torque, then force, in B's axes) about the point `offset` from
/// the node.
Eigen::MatrixXd node_loads(const BodyNode& node, const Vector3d& offset = Vector3d::Zero());

}  // namespace flexura::mbs
