// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <kdl/tree.hpp>
#include <kdl/treeidsolver_recursive_newton_euler.hpp>
#include <map>
#include <string>

/// A robot as urdfdom reads it and KDL moves it.
namespace flexura::test {

inline KDL::Frame to_kdl(const urdf::Pose& p) {
  return {KDL::Rotation::Quaternion(p.rotation.x, p.rotation.y, p.rotation.z, p.rotation.w),
          KDL::Vector(p.position.x, p.position.y, p.position.z)};
}

/// Its constructor takes the inertia about the centre of mass, in the axes of the link.
inline KDL::RigidBodyInertia to_kdl(const urdf::Inertial& i) {
  const KDL::Frame X = to_kdl(i.origin);
  const KDL::RigidBodyInertia turned =
      X.M * KDL::RigidBodyInertia(i.mass, KDL::Vector::Zero(),
                                  KDL::RotationalInertia(i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz));
  return KDL::RigidBodyInertia(i.mass, X.p, turned.getRotationalInertia());
}

inline KDL::Joint to_kdl(const urdf::Joint& joint) {
  const KDL::Frame F = to_kdl(joint.parent_to_joint_origin_transform);
  const KDL::Vector axis = F.M * KDL::Vector(joint.axis.x, joint.axis.y, joint.axis.z);
  if (joint.type == urdf::Joint::PRISMATIC) return {joint.name, F.p, axis, KDL::Joint::TransAxis};
  if (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS)
    return {joint.name, F.p, axis, KDL::Joint::RotAxis};
  return KDL::Joint(joint.name, KDL::Joint::Fixed);
}

inline void add_below(KDL::Tree& tree, const urdf::LinkConstSharedPtr& link) {
  for (const urdf::LinkSharedPtr& child : link->child_links) {
    const urdf::Joint& joint = *child->parent_joint;
    tree.addSegment(KDL::Segment(child->name, to_kdl(joint), to_kdl(joint.parent_to_joint_origin_transform),
                                 child->inertial ? to_kdl(*child->inertial) : KDL::RigidBodyInertia::Zero()),
                    link->name);
    add_below(tree, child);
  }
}

/// Accelerations by joint, at rest at `q` (0 where it has none) under gravity 9.81 m/s^2 along -z, on a root that stands: H q'' = -h,
/// both by recursive Newton-Euler.  No joint mimics.
inline std::map<std::string, double> kdl_accelerations(const urdf::ModelInterfaceSharedPtr& model,
                                                       const std::map<std::string, double>& q = {}) {
  KDL::Tree tree(model->getRoot()->name);
  add_below(tree, model->getRoot());
  const unsigned n = tree.getNrOfJoints();
  KDL::TreeIdSolver_RNE solver(tree, KDL::Vector(0, 0, -9.81)), weightless(tree, KDL::Vector::Zero());
  KDL::JntArray at(n), rest(n), unit(n), torques(n);
  std::map<std::string, unsigned> places;
  for (const auto& [name, element] : tree.getSegments())
    if (const KDL::Joint& joint = element.segment.getJoint(); joint.getType() != KDL::Joint::Fixed) {
      places[joint.getName()] = element.q_nr;
      if (const auto given = q.find(joint.getName()); given != q.end()) at(element.q_nr) = given->second;
    }
  if (n == 0) return {};
  solver.CartToJnt(at, rest, rest, {}, torques);
  const Eigen::VectorXd h = torques.data;
  Eigen::MatrixXd H(n, n);
  for (unsigned k = 0; k < n; ++k) {
    unit.data = Eigen::VectorXd::Unit(n, k);
    weightless.CartToJnt(at, rest, unit, {}, torques);
    H.col(k) = torques.data;
  }
  const Eigen::VectorXd
      scale = H.diagonal().cwiseSqrt().cwiseInverse(),
      a = scale.asDiagonal() *
          (scale.asDiagonal() * H * scale.asDiagonal()).eval().ldlt().solve(-scale.cwiseProduct(h));
  std::map<std::string, double> out;
  for (const auto& [name, place] : places) out[name] = a[place];
  return out;
}

}  // namespace flexura::test
