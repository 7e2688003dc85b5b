// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/measures/shown_measure.hpp"

namespace flexura::mbs {

/// One of the numbers that a joint, a drive, a constraint or a force element exerts, as results show it.
class Reaction final : public ShownMeasure {
 public:
  /// `output`: which of the element's outputs; of a joint those of wrench_outputs(true, true).
  Reaction(std::string name, Exerted by, int output, input::Dimension dimension, double guess = 0.0)
      : ShownMeasure(std::move(name)), by_(by), output_(output), dimension_(dimension), guess_(guess) {}
  input::Dimension dimension() const override { return dimension_; }
  double value(const Kinematics&, const double*) const override { return 0.0; }
  Exerted exerted() const override { return by_; }
  double guess() const override { return guess_; }
  double value_of_load(const Kinematics&, const double* load) const override {
    if (by_.by != Exerted::By::joint) return load[output_];
    // Sizes of force and torque, then their components; the wrench has the torque first.
    const Eigen::Map<const Vector6d> on_M(load);
    if (output_ == 0) return on_M.tail<3>().norm();
    if (output_ == 1) return on_M.head<3>().norm();
    return output_ < 5 ? on_M(3 + output_ - 2) : on_M(output_ - 5);
  }

 private:
  Exerted by_;
  int output_;
  input::Dimension dimension_;
  double guess_;
};

}  // namespace flexura::mbs
