// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/forces/friction.hpp"

namespace flexura::mbs {
namespace {

/// Friction along a joint's coordinate by a smooth law of its speed v,
///
///     F = -(F_c + (F_s - F_c) exp(-(v / v_s)^2)) tanh(v / v_t) - d v
///
/// Coulomb friction F_c, static friction F_s that fades over the Stribeck speed v_s, and a transition speed
/// v_t over which the sign is smoothed: below it the joint creeps where it would stick.
class JointFriction final : public ForceElement {
 public:
  JointFriction(std::string name, CoordinateRef c, const FrictionLaw& law, double transition_speed)
      : ForceElement(std::move(name)), c_(c), law_(law), transition_speed_(transition_speed) {}
  std::string_view type() const override { return "joint_friction"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::vector<CoordinateRef> coordinates() const override { return {c_}; }
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
  std::vector<OutputInfo> outputs() const override {
    return {{"force", input::dim::none, "along the coordinate: N, or N m for an angle"}};
  }
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
};

}  // namespace

ForceType joint_friction_force() {
  using namespace input;
  return {
      "joint_friction",
      "Friction along a joint's coordinate by a smooth law with Stribeck effect. All in N, m/s or N m, "
      "rad/s.",
      friction_keys({expression("transition_speed", "speed over which the sign changes").or_default("0.001")},
                    "speed over which it falls"),
      [](const std::string& name, const Section& s,
         const ReadContext& context) -> std::shared_ptr<const ForceElement> {
        const CoordinateRef c = context.speed(s, "joint", "coordinate");
        const FrictionLaw law =
            read_friction(s, context, {.static_may_vanish = true, .stribeck_may_vanish = false});
        return std::make_shared<JointFriction>(name, c, law,
                                               read_size(s, context, "transition_speed", false));
      }};
}

}  // namespace flexura::mbs
