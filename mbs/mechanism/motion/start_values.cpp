// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/motion/start_values.hpp"

namespace flexura::mbs {

void put_rotation(const DrivenRotation& wanted, const JointPlace& place, Eigen::VectorXd& p,
                  Eigen::VectorXd& v) {
  p.segment<4>(place.i_p) = quaternion_of_rotation(wanted.R);
  v.segment<3>(place.i_v) = wanted.w;
}

void StartValues::stand_at(int b, const Pose& X_WB, const Motion& motion) {
  const TreeBody& body = tree_.bodies[b];
  const JointPlace& place = tree_.places[body.joint];
  const Pose X =
      motion.kin.markers[body.marker_in].X_WP.inverse() * X_WB * motion.local[body.marker_out].X_BP;
  place.joint->coordinates_of(body.reversed ? X.inverse() : X, p.data() + place.i_p);
}

StartValues::StartValues(const Topology& tree, const TreeMotion& kinematics, const Coordinates& coordinates)
    : tree_(tree), kinematics_(kinematics) {
  p = Eigen::VectorXd::Zero(tree_.n_p);
  v = Eigen::VectorXd::Zero(tree_.n_v);
  given_p.assign(tree_.n_p, false);
  given_v.assign(tree_.n_v, false);
  for (const JointPlace& place : tree_.places)
    if (place.in_tree()) place.joint->reference(p.data() + place.i_p);

  Motion at;
  kinematics_.size(at);
  const double t_0 = 0.0;
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    const JointDescription& joint = tree_.d.joints[body.joint];
    const JointPlace& place = tree_.places[body.joint];
    // The pieces of a beam start as made, wherever the beam is held and however roughly its place is given.
    if (tree_.d.bodies[b].X_WB && !joint.bends) {
      kinematics_.forward(TreeMotion::Level::position, 0.0, p.data(), nullptr, nullptr, at);
      stand_at(b, *tree_.d.bodies[b].X_WB, at);
    }
    for (const auto& [index, motion] : joint.drives) {
      if (!motion->reads().empty()) continue;  // of states: Mechanism::initial_state
      const Jet f = motion->time_derivatives(0.0);
      p[place.i_p + joint.coordinate_of_speed(index)] = f.value;
      v[place.i_v + index] = f.first;
    }
    for (const auto& [index, motion] : joint.speed_drives)
      if (motion->reads().empty()) v[place.i_v + index] = motion->evaluate(&t_0);
    if (joint.rotation_drive && !joint.rotation_drive->follows())
      put_rotation(joint.rotation_drive->at_time(0.0), place, p, v);
    for (const auto& [index, value] : joint.initial_coordinates) {
      p[place.i_p + index] = value;
      given_p[place.i_p + index] = true;
    }
    for (const auto& [index, value] : joint.initial_speeds) {
      v[place.i_v + index] = value;
      given_v[place.i_v + index] = true;
    }
  }
  follow_split_joints();
  // Initial coordinates may hold quaternions of any length.
  const Eigen::VectorXd given = p;
  coordinates.retract(given, Eigen::VectorXd::Zero(tree_.n_v), p);
}

void StartValues::drive_at(double t, Eigen::VectorXd& at_p, Eigen::VectorXd& at_v) const {
  for (const int b : tree_.order) {
    const JointDescription& joint = tree_.d.joints[tree_.bodies[b].joint];
    const JointPlace& place = tree_.places[tree_.bodies[b].joint];
    const auto put = [&](Eigen::VectorXd& to, const std::vector<bool>& given, int k, double value) {
      if (!given[static_cast<std::size_t>(k)]) to[k] = value;
    };
    for (const auto& [index, motion] : joint.drives) {
      if (!motion->reads().empty()) continue;
      const Jet f = motion->time_derivatives(t);
      put(at_p, given_p, place.i_p + joint.coordinate_of_speed(index), f.value);
      put(at_v, given_v, place.i_v + index, f.first);
    }
    for (const auto& [index, motion] : joint.speed_drives)
      if (motion->reads().empty()) put(at_v, given_v, place.i_v + index, motion->evaluate(&t));
    if (joint.rotation_drive && !joint.rotation_drive->follows())
      put_rotation(joint.rotation_drive->at_time(t), place, at_p, at_v);
  }
}

// A body that floats because its joint became a constraint starts where that joint, in its reference position and at rest,
// would have put it.
void StartValues::follow_split_joints() {
  if (tree_.whole_order.empty()) return;
  Motion motion;
  kinematics_.size(motion);
  for (const int b : tree_.whole_order) {
    const int j = tree_.split_joint[b];
    if (j < 0) continue;
    const JointDescription& joint = tree_.d.joints[j];
    kinematics_.forward(TreeMotion::Level::velocity, 0.0, p.data(), v.data(), nullptr, motion);
    const bool reversed = tree_.d.markers[joint.marker_F].body == b;
    const int in = reversed ? joint.marker_M : joint.marker_F,
              out = reversed ? joint.marker_F : joint.marker_M;
    const MarkerState& parent = motion.kin.markers[in];
    double q[7] = {};
    joint.joint->reference(q);
    const Pose X_in_out = reversed ? joint.joint->pose(q).inverse() : joint.joint->pose(q);
    const Pose X_WB =
        tree_.d.bodies[b].X_WB.value_or(parent.X_WP * X_in_out * motion.local[out].X_BP.inverse());
    const Vector3d r = X_WB.p - parent.X_WP.p;
    const Spatial V = {parent.V.angular, parent.V.linear + parent.V.angular.cross(r)};

    // Its own joint, six freedoms to ground (or what closed a loop before).
    const TreeBody& body = tree_.bodies[b];
    if (body.parent != 0 || body.reversed) continue;
    const JointPlace& place = tree_.places[body.joint];
    stand_at(b, X_WB, motion);
    const Vector3d to_M = X_WB.R * motion.local[body.marker_out].X_BP.p;
    const Spatial V_FM = motion.kin.markers[body.marker_in].X_WP.R.transpose() *
                         Spatial{V.angular, V.linear + V.angular.cross(to_M)};
    place.joint->speeds_of(p.data() + place.i_p, V_FM.vector(), v.data() + place.i_v);
  }
}

}  // namespace flexura::mbs
