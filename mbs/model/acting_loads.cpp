// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/acting_loads.hpp"

#include <algorithm>
#include <set>

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;

/// Unit wrenches (torque, force) about the marker in its own axes, as loads on the superelement.
MatrixXd marker_loads(const BodyNodes& nodes, const MarkerDescription& marker) {
  const Matrix3d& R = marker.X_BP.R;
  Matrix6d axes = Matrix6d::Zero();
  axes.topLeftCorner<3, 3>() = R;
  axes.bottomRightCorner<3, 3>() = R;
  const BodyNode& node = nodes[node_of(marker)];
  const Vector3d offset = marker.node >= 0 ? marker.X_BP.p : Vector3d(marker.X_BP.p - node.p_BoN_B);
  return node_loads(node, offset) * axes;
}

/// The directions a joint locks, in its frame F.  Rotations first, as in a twist.
std::vector<int> locked_directions(const Joint& joint) {
  std::vector<double> q(std::max(joint.n_p(), 1));
  joint.reference(q.data());
  MotionMatrix S(6, joint.n_v());
  joint.motion(q.data(), S);
  std::vector<int> locked;
  for (int k = 0; k < 6; ++k)
    if (S.row(k).isZero(1e-12)) locked.push_back(k);
  return locked;
}

}  // namespace

int marker_on(const MechanismDescription& d, const JointDescription& joint, int body) {
  for (const int marker : {joint.marker_F, joint.marker_M})
    if (d.markers[marker].body == body) return marker;
  return -1;
}

int node_of(const MarkerDescription& marker) {
  return std::max(marker.node, marker.ked_node);
}

const JointDescription* frame_joint(const MechanismDescription& d, int body) {
  for (const bool cut : {false, true})
    for (const JointDescription& joint : d.joints)
      if (joint.cut == cut)
        if (const int marker = marker_on(d, joint, body); marker >= 0 && node_of(d.markers[marker]) >= 0)
          return &joint;
  return nullptr;
}

MatrixXd held_directions(const BodyNodes& nodes, const MechanismDescription& d, const JointDescription& joint,
                         int body) {
  const MarkerDescription& marker = d.markers[marker_on(d, joint, body)];
  const MatrixXd all = marker_loads(nodes, marker);
  const std::vector<int> locked = locked_directions(*joint.joint);
  MatrixXd held(all.rows(), locked.size());
  for (std::size_t k = 0; k < locked.size(); ++k) held.col(k) = all.col(locked[k]);
  return held;
}

MatrixXd held_by_joints(const superelement::Superelement& se, const BodyNodes& nodes,
                        const MechanismDescription& d, int body) {
  const MatrixXd R = superelement::rigid_motions(se);
  // As a rigid body of about its own size sees them: lengths count like radians.
  double size = 0.0;
  for (const superelement::Interface& a : se.interfaces)
    for (const superelement::Interface& b : se.interfaces)
      size = std::max(size, (a.p_BoN_B - b.p_BoN_B).norm());
  if (!(size > 0.0)) size = 1.0;
  MatrixXd held(se.n(), 0);
  std::vector<Vector6d> basis;
  for (const bool displacements : {true, false})
    for (const JointDescription& joint : d.joints) {
      const int marker = marker_on(d, joint, body);
      if (marker < 0 || node_of(d.markers[marker]) < 0) continue;
      const MatrixXd all = marker_loads(nodes, d.markers[marker]);
      for (const int k : locked_directions(*joint.joint)) {
        if ((k >= 3) != displacements) continue;
        Vector6d row = R.transpose() * all.col(k);
        row.tail<3>() /= size;  // columns of R: translations, then rotations
        row.normalize();
        for (int pass = 0; pass < 2; ++pass)
          for (const Vector6d& q : basis) row -= q.dot(row) * q;
        if (row.norm() < 1e-3) continue;  // a frame must not hang on nearly parallel directions
        basis.push_back(row.normalized());
        held.conservativeResize(Eigen::NoChange, held.cols() + 1);
        held.rightCols<1>() = all.col(k);
      }
    }
  return held;
}

MatrixXd loads_on(const BodyNodes& nodes, const MechanismDescription& d, int body, int node) {
  const JointDescription* only = nullptr;
  int acting = 0;
  bool drives_or_joint_forces = false;
  for (const JointDescription& joint : d.joints) {
    const int marker = marker_on(d, joint, body);
    if (marker < 0 || node_of(d.markers[marker]) != node) continue;
    ++acting;
    only = &joint;
    drives_or_joint_forces = !joint.drives.empty();
  }
  for (const auto& force : d.forces) {
    const auto [from, to] = force->markers();
    // Forces without markers act on joint coordinates.
    if (from < 0 && to < 0) drives_or_joint_forces = true;
    for (const int marker : {from, to})
      if (marker >= 0 && d.markers[marker].body == body && node_of(d.markers[marker]) == node) acting += 2;
  }
  for (const auto& constraint : d.constraints)
    if (const auto* relative = dynamic_cast<const RelativeConstraint*>(constraint.get()))
      for (const int marker : {relative->marker_F(), relative->marker_M()})
        if (d.markers[marker].body == body && node_of(d.markers[marker]) == node) acting += 2;
  const std::set<std::string_view> turning = {"revolute", "cylindrical", "spherical"};
  if (acting != 1 || drives_or_joint_forces || !only || !turning.contains(only->joint->type()))
    return node_loads(nodes[node]);
  const MatrixXd all = marker_loads(nodes, d.markers[marker_on(d, *only, body)]);
  if (only->joint->type() == "spherical") return all.rightCols(3);
  MatrixXd loads(all.rows(), 5);  // z is the axis; along it a cylindrical joint slides, perhaps with friction
  loads << all.leftCols(2), all.rightCols(3);
  return loads;
}

std::vector<int> loaded_nodes(const MechanismDescription& d, int body) {
  std::set<int> found;
  const auto take = [&](int marker) {
    if (marker >= 0 && d.markers[marker].body == body && node_of(d.markers[marker]) >= 0)
      found.insert(node_of(d.markers[marker]));
  };
  for (const JointDescription& joint : d.joints) {
    if (joint.joint->type() == "six_dof") continue;  // carries no load
    take(joint.marker_F);
    take(joint.marker_M);
  }
  for (const auto& force : d.forces) {
    const auto [from, to] = force->markers();
    take(from);
    take(to);
  }
  for (const auto& constraint : d.constraints)
    if (const auto* relative = dynamic_cast<const RelativeConstraint*>(constraint.get())) {
      take(relative->marker_F());
      take(relative->marker_M());
    }
  return {found.begin(), found.end()};
}

}  // namespace flexura::mbs
