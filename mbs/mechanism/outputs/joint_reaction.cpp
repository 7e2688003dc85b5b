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

double value_of_multipliers(const Topology& tree, const ConstraintRows& rows_of, const Measure& measure,
                            Motion& motion, const Wrenches& wrenches, RowValues& rows) {
  const Exerted exerted = measure.exerted();
  switch (exerted.by) {
    case Exerted::By::joint: {
      const Vector6d load = joint_reaction(tree, rows_of, exerted.element, motion, wrenches, rows);
      return measure.value_of_load(motion.kin, load.data());
    }
    case Exerted::By::drive: {
      const double load = -rows.x(rows_of.drive_of({exerted.element, exerted.coordinate}));
      return measure.value_of_load(motion.kin, &load);
    }
    case Exerted::By::constraint: {
      const std::size_t k = rows_of.first_own() + static_cast<std::size_t>(exerted.element);
      const Constraint& constraint = *rows_of.constraints()[k];
      thread_local std::vector<double> outputs;
      outputs.resize(constraint.outputs().size());
      rows_of.own_contact(k, motion, rows);
      constraint.evaluate_outputs(motion.kin, rows.x.data() + rows_of.first_row(k), outputs.data());
      return measure.value_of_load(motion.kin, outputs.data());
    }
    default:
      return 0.0;
  }
}

double shown_value(const Topology& tree, const ConstraintRows& rows_of, const ElementStates& states,
                   const Measure& measure, Motion& motion, const Wrenches& wrenches, RowValues& rows,
                   const Signals& signals) {
  const Exerted exerted = measure.exerted();
  if (exerted.by == Exerted::By::none) return measure.value(motion.kin, signals.values.data());
  if (exerted.by != Exerted::By::force)
    return value_of_multipliers(tree, rows_of, measure, motion, wrenches, rows);
  const auto i = static_cast<std::size_t>(exerted.element);
  thread_local std::vector<double> outputs;
  outputs.resize(tree.d.forces[i]->outputs().size());
  states.own_states(i, motion, signals);
  tree.d.forces[i]->evaluate_outputs(motion.kin, signals.values.data(), outputs.data());
  return measure.value_of_load(motion.kin, outputs.data());
}

}  // namespace flexura::mbs
