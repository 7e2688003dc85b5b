// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/dynamics/inverse_dynamics.hpp"
#include "mbs/mechanism/elements/constraint_rows.hpp"
#include "mbs/mechanism/elements/element_states.hpp"

namespace flexura::mbs {

/// The wrench (torque about Mo, force, in F) that goes through a joint, on the body of M: after InverseDynamics::backward()
/// with multipliers in `rows` and what forces put on closures in `wrenches`.
Vector6d joint_reaction(const Topology& tree, const ConstraintRows& rows_of, int joint, const Motion& motion,
                        const Wrenches& wrenches, const RowValues& rows);

/// The value of a measure, of what an element exerts or of motion; likewise, with signals evaluated.
double shown_value(const Topology& tree, const ConstraintRows& rows_of, const ElementStates& states,
                   const Measure& measure, Motion& motion, const Wrenches& wrenches, RowValues& rows,
                   const Signals& signals);
/// The part of it that multipliers in `rows` alone make.
double value_of_multipliers(const Topology& tree, const ConstraintRows& rows_of, const Measure& measure,
                            Motion& motion, const Wrenches& wrenches, RowValues& rows);

}  // namespace flexura::mbs
