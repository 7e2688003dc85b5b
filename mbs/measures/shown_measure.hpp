// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/measures/measure.hpp"

namespace flexura::mbs {

/// A measure of what is known after the equations of motion are solved, accelerations and reactions: results show it, and
/// formulas that results show may read it; forces and controls may not, and it needs no derivatives.
class ShownMeasure : public Measure {
 public:
  using Measure::Measure;
  void differentiate(const Kinematics&, const double*, Derivatives&) const override {}
  /// The joint whose reaction it takes; -1: none, it is value().
  virtual int joint() const { return -1; }
  /// Its value where this wrench (torque about Mo, force, in F) goes through that joint, on the body of M.
  virtual double value_of_load(const Kinematics& /*kin*/, const Vector6d& /*on_M_F*/) const { return 0.0; }
};

}  // namespace flexura::mbs
