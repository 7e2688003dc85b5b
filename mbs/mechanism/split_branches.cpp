// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <set>

#include "mbs/mechanism/work.hpp"

/// Long branches of flexible bodies.  In the coordinates of a tree every body's equations hold those of all
/// bodies inboard of it: the matrices of a chain of n bodies with m modes are full, and factors cost (n m)^3.
/// A joint that stands as a constraint parts them: each body then knows its neighbours alone, and factors
/// cost n m^3.  Measured on chains with 20 modes (tests/benchmarks/run chains): as fast at five bodies, twice
/// at seven, seven times at fourteen.
namespace flexura::mbs {
namespace {

constexpr int kMostBodies = 5;  // modal ones behind one another
constexpr int kMostModes = 100;

}  // namespace

/// Marks joints that are to stand as constraints; true where there is one.  Joints whose coordinates anything
/// sets, drives, loads or reads keep them: as constraints these would not count turns.
bool Mechanism::split_branches() {
  // Coordinates of small deformations: dense matrices are all that couples them.
  const auto is_modal = [&](int b) {
    const FlexibleBody* const flexible = d_.bodies[b].flexible.get();
    return flexible && flexible->acts_back() && flexible->is_linear();
  };
  std::vector<int> bodies_before(bodies_.size(), 0), modes_before(bodies_.size(), 0);
  bool is_long = false;
  for (const int b : order_) {
    const int parent = bodies_[b].parent;
    bodies_before[b] = bodies_before[parent] + is_modal(b);
    modes_before[b] = modes_before[parent] + (is_modal(b) ? d_.bodies[b].flexible->m() : 0);
    is_long = is_long || (bodies_before[b] > kMostBodies && modes_before[b] > kMostModes);
  }
  if (!is_long) return false;

  std::set<int> wanted;
  for (const auto& constraint : d_.constraints)
    for (const CoordinateRef& c : constraint->coordinates()) wanted.insert(c.joint);
  for (const auto& force : d_.forces)
    for (const CoordinateRef& c : force->coordinates()) wanted.insert(c.joint);
  // The names of all coordinates are there for formulas; what counts is whether one reads them.
  std::set<int> read;
  const auto note = [&](const std::vector<int>& signals) { read.insert(signals.begin(), signals.end()); };
  for (const auto& force : d_.forces) note(force->reads());
  for (const auto& control : d_.controls) note(control->reads());
  for (const auto& measure : d_.measures) note(measure->reads());
  const auto is_free = [&](int j) {
    const JointDescription& joint = d_.joints[j];
    if (joint.keep_in_tree || joint.is_driven() || wanted.contains(j) || joint.joint->n_rows() == 0 ||
        !joint.initial_coordinates.empty() || !joint.initial_speeds.empty())
      return false;
    const auto is_read = [&](const CoordinateInfo& c) {
      return read.contains(d_.signals.find(joint.name + "." + c.name));
    };
    return std::ranges::none_of(joint.joint->coordinates(), is_read) &&
           std::ranges::none_of(joint.joint->speeds(), is_read);
  };
  // Between a flexible body and the next one inboard: the joint nearest to the outer one that may go.
  whole_order_ = order_;
  split_joint_.assign(bodies_.size(), -1);
  bool any = false;
  for (const int b : order_) {
    if (!is_modal(b)) continue;
    int begins = -1;  // the branch, with this body
    for (int k = b; k != 0; k = bodies_[k].parent) {
      if (k != b && is_modal(k)) break;
      if (split_joint_[k] >= 0) {
        begins = -1;
        break;
      }
      if (begins < 0 && is_free(bodies_[k].joint)) begins = k;
      if (bodies_[k].parent == 0) begins = -1;  // no flexible body inboard
    }
    if (begins < 0) continue;
    const int j = bodies_[begins].joint;
    split_joint_[begins] = j;
    d_.joints[j].cut = d_.joints[j].splits = true;
    any = true;
  }
  if (!any) whole_order_.clear();
  return any;
}

/// A body that floats because its joint became a constraint starts where that joint, in its reference
/// position and at rest, would have put it.
void Mechanism::follow_split_joints() {
  if (whole_order_.empty()) return;
  const auto scratch = make_scratch();
  Work& work = work_of(*scratch);
  for (const int b : whole_order_) {
    const int j = split_joint_[b];
    if (j < 0) continue;
    const JointDescription& joint = d_.joints[j];
    forward(Level::velocity, 0.0, p_0_.data(), v_0_.data(), nullptr, work);
    const bool reversed = d_.markers[joint.marker_F].body == b;
    const int in = reversed ? joint.marker_M : joint.marker_F,
              out = reversed ? joint.marker_F : joint.marker_M;
    const MarkerState& parent = work.kin.markers[in];
    double q[7] = {};
    joint.joint->reference(q);
    const Pose X_in_out = reversed ? joint.joint->pose(q).inverse() : joint.joint->pose(q);
    const Pose X_WB = d_.bodies[b].X_WB.value_or(parent.X_WP * X_in_out * work.local[out].X_BP.inverse());
    const Vector3d r = X_WB.p - parent.X_WP.p;
    const Spatial V = {parent.V.angular, parent.V.linear + parent.V.angular.cross(r)};

    // Its own joint, six freedoms to ground (or what closed a loop before).
    const TreeBody& body = bodies_[b];
    if (body.parent != 0 || body.reversed) continue;
    const JointPlace& place = places_[body.joint];
    stand_at(b, X_WB, work);
    const Vector3d to_M = X_WB.R * work.local[body.marker_out].X_BP.p;
    const Spatial V_FM = work.kin.markers[body.marker_in].X_WP.R.transpose() *
                         Spatial{V.angular, V.linear + V.angular.cross(to_M)};
    place.joint->speeds_of(p_0_.data() + place.i_p, V_FM.vector(), v_0_.data() + place.i_v);
  }
}

}  // namespace flexura::mbs
