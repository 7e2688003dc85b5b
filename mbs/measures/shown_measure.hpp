// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/measures/measure.hpp"

namespace flexura::mbs {

/// A measure of what is known after the equations of motion are solved, accelerations and reactions.  Where forces or
/// controls read it, it is an algebraic state that is solved for with these (Residual::coupled_equations); it needs no
/// derivatives.
class ShownMeasure : public Measure {
 public:
  using Measure::Measure;
  void differentiate(const Kinematics&, const double*, Derivatives&) const override {}
  bool is_only_shown() const final { return true; }
};

}  // namespace flexura::mbs
