// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/forces/force.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {

/// A force (or torque) along a coordinate of a joint, by formula: positive where it speeds the coordinate up.
class JointForce final : public ForceElement {
 public:
  /// `along`: dimension of a force along the coordinate.
  JointForce(std::string name, CoordinateRef speed, std::shared_ptr<const Expression> value,
             input::Dimension along = input::dim::none)
      : ForceElement(std::move(name)), speed_(speed), value_(std::move(value)), along_(along) {}
  std::string_view type() const override { return "joint_force"; }
  std::vector<CoordinateRef> coordinates() const override { return {speed_}; }
  std::vector<int> reads() const override { return value_->reads(); }
  ForceNature nature() const override { return ForceNature::load; }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double* signals) const override {
    auto rest = std::make_shared<JointForce>(*this);
    rest->load_ = value_->evaluate(signals);
    return rest;
  }
  void apply(const Kinematics&, const double* signals, Loads& loads) const override {
    loads.apply(speed_, value(signals));
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics&, const double* signals, Derivatives& d) const override {
    d.force(speed_, value(signals));
    d.by_formula(*value_, signals);
  }
  void add_powers(const Kinematics& kin, const double* signals, Powers& powers) const override {
    powers.input += value(signals) * kin.speed(speed_);
  }
  std::vector<OutputInfo> outputs() const override { return {{"force", along_, "along the coordinate"}}; }
  void evaluate_outputs(const Kinematics&, const double* signals, double* values) const override {
    values[0] = value(signals);
  }

 private:
  double value(const double* signals) const { return value_->evaluate(signals) - load_; }

  CoordinateRef speed_;
  std::shared_ptr<const Expression> value_;
  input::Dimension along_;
  double load_ = 0.0;  ///< taken away
};

}  // namespace flexura::mbs
