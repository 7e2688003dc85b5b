// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/forces/force.hpp"
#include "mbs/forces/friction.hpp"
#include "mbs/kinematics/robot_words.hpp"

namespace flexura::mbs {

/// Friction along a joint's coordinate by a smooth law of its speed v,
///
///     F = -(F_c + (F_s - F_c) exp(-(v / v_s)^2)) tanh(v / v_t) - d v
///
/// Coulomb friction F_c, static friction F_s that fades over the Stribeck speed v_s, and a transition speed
/// v_t over which the sign is smoothed: below it the joint creeps where it would stick, under a load T < F_c without the
/// other two at v_t artanh(T / F_c).
class JointFriction final : public ForceElement, public HasRobotWords {
 public:
  /// `along`: dimension of a force along the coordinate.
  JointFriction(std::string name, CoordinateRef c, const FrictionLaw& law, double transition_speed,
                input::Dimension along = input::dim::none)
      : ForceElement(std::move(name)), c_(c), law_(law), transition_speed_(transition_speed), along_(along) {}
  std::string_view type() const override { return "joint_friction"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::vector<CoordinateRef> coordinates() const override { return {c_}; }
  double transition_speed() const { return transition_speed_; }
  /// Without static friction, for which there is no word.
  std::optional<JointWords> joint_words() const override {
    if (law_.static_force != law_.coulomb) return std::nullopt;
    return JointWords{.coordinate = c_, .damping = law_.viscous, .friction = law_.coulomb};
  }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply(c_, force(kin.speed(c_)));
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    const double v = kin.speed(c_), step = std::tanh(v / transition_speed_);
    d.force(c_, force(v));
    d.by_speed(c_, -law_.sliding_slope(v) * step - law_.sliding(v) * (1.0 - step * step) / transition_speed_ -
                       law_.viscous);
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    const double v = kin.speed(c_);
    powers.dissipated -= force(v) * v;
  }
  std::vector<OutputInfo> outputs() const override { return {{"force", along_, "along the coordinate"}}; }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    values[0] = force(kin.speed(c_));
  }

 private:
  double force(double v) const {
    return -law_.sliding(v) * std::tanh(v / transition_speed_) - law_.viscous * v;
  }
  CoordinateRef c_;
  FrictionLaw law_;
  double transition_speed_;
  input::Dimension along_;
};

}  // namespace flexura::mbs
