// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/outputs/joint_reaction.hpp"

namespace flexura::mbs {

Vector6d joint_reaction(const Topology& tree, const ConstraintRows& rows_of, int joint, const Motion& motion,
                        const Wrenches& wrenches, const RowValues& rows) {
  const JointPlace& place = tree.places[joint];
  const Pose &F = motion.kin.markers[place.marker_F].X_WP, &M = motion.kin.markers[place.marker_M].X_WP;
  if (!place.in_tree()) {
    const auto [closure, k] = rows_of.closure(joint);
    if (!closure) return wrenches.on_closure[joint];
    return wrenches.on_closure[joint] -
           closure->wrench_on_M(motion.kin, rows.x.data() + rows_of.first_row(k));
  }
  for (int b : tree.order) {
    if (tree.bodies[b].joint != joint) continue;
    const Spatial& through = wrenches.bodies[b].through_joint;
    if (!tree.bodies[b].reversed) return (F.R.transpose() * through).vector();
    const Spatial on_M = shift_wrench(through, F.p - M.p);
    return -(F.R.transpose() * on_M).vector();
  }
  return Vector6d::Zero();
}

double shown_value(const Topology& tree, const ConstraintRows& rows_of, const Measure& measure,
                   const Motion& motion, const Wrenches& wrenches, const RowValues& rows,
                   const double* signals) {
  const int joint = measure.joint();
  if (joint < 0) return measure.value(motion.kin, signals);
  return measure.value_of_load(motion.kin, joint_reaction(tree, rows_of, joint, motion, wrenches, rows));
}

}  // namespace flexura::mbs
