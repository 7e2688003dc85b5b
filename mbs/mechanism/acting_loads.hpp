// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "mbs/bodies/body_node.hpp"
#include "mbs/mechanism/mechanism.hpp"

/// What joints, constraints and forces of a mechanism hold of a flexible body and load it with: boundary
/// conditions, frames and response modes follow from it.  `nodes` are all of the body's, interfaces first.
namespace flexura::mbs {

using BodyNodes = std::vector<BodyNode>;

/// Marker of a joint on the body, or -1.
int marker_on(const MechanismDescription& d, const JointDescription& joint, int body);

/// True where the directions that the joint locks stand still in the body, whatever its coordinates: only then
/// do they give the body a boundary condition.
bool locks_the_same_wherever_it_is(const MechanismDescription& d, const JointDescription& joint, int body);

/// The joint that a joint-fixed frame sits on: the first one (not cut) that leads to the body.
const JointDescription* frame_joint(const MechanismDescription& d, int body);

/// The joint that leads from the body to one which nothing else holds or carries, and which hangs on it so; nullptr where there
/// is none.
const JointDescription* joint_to_payload(const MechanismDescription& d, int body);

/// n_se x k: the directions that the joint locks at its marker on the body, those along which it ties a translation to a turn
/// (a thread) by what it ties.
Eigen::MatrixXd held_directions(const BodyNodes& nodes, const MechanismDescription& d,
                                const JointDescription& joint, int body);

/// True where the node keeps all that these directions are made of: rigid motions of the body go through them, then.
bool keeps(const superelement::Superelement& se, const BodyNodes& nodes, const MechanismDescription& d,
           const JointDescription& joint, int body);

/// Where the joints hold a body: at most six of the directions that they lock, independent for a rigid body,
/// displacements before rotations, in the order of the file.
Eigen::MatrixXd held_by_joints(const superelement::Superelement& se, const BodyNodes& nodes,
                               const MechanismDescription& d, int body);

/// The nodes (indices) that joints, constraints and forces of the mechanism act on.
std::vector<int> loaded_nodes(const MechanismDescription& d, int body);

/// Loads that what acts on the node can put on it: all six, less the torques of a joint that turns freely
/// there, where nothing else acts.
Eigen::MatrixXd loads_on(const BodyNodes& nodes, const MechanismDescription& d, int body, int node);

/// Whether what acts on the node can load it along u_x .. theta_z of its axes: a joint does where it locks, all else anywhere.
std::array<bool, 6> loaded_directions(const BodyNodes& nodes, const MechanismDescription& d, int body,
                                      int node);

}  // namespace flexura::mbs
