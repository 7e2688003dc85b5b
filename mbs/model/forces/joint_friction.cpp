// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/forces/types.hpp"

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
  struct Law {
    double coulomb, static_force, stribeck_speed, transition_speed, viscous;
  };
  JointFriction(std::string name, CoordinateRef c, const Law& law)
      : ForceElement(std::move(name)), c_(c), law_(law) {}
  std::string_view type() const override { return "joint_friction"; }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply(c_, force(kin.speed(c_)));
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
    const double x = v / law_.stribeck_speed;
    const double size = law_.coulomb + (law_.static_force - law_.coulomb) * std::exp(-x * x);
    return -size * std::tanh(v / law_.transition_speed) - law_.viscous * v;
  }
  CoordinateRef c_;
  Law law_;
};

}  // namespace

ForceType joint_friction_force() {
  using namespace input;
  return {"joint_friction",
          "Friction along a joint's coordinate by a smooth law with Stribeck effect. All in N, m/s or N m, "
          "rad/s.",
          {text("joint", "the joint").required(),
           text("coordinate", "its coordinate, where it has more than one: \"angle\", \"position\", ..."),
           expression("coulomb", "friction at high speed").required(),
           expression("static", "greatest friction near rest; without it that at high speed"),
           expression("stribeck_speed", "speed over which it falls").or_default("0.01"),
           expression("transition_speed", "speed over which the sign changes").or_default("0.001"),
           expression("viscous", "beside it, force per speed").or_default("0")},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const CoordinateRef c = context.speed(s, "joint", "coordinate");
            const auto number = [&](const char* key, bool may_vanish) {
              const double x = context.number(s, key);
              if (x < 0.0 || (x == 0.0 && !may_vanish))
                s.refuse(key, may_vanish ? "must not be negative" : "must be above 0");
              return x;
            };
            JointFriction::Law law;
            law.coulomb = number("coulomb", true);
            law.static_force = s.has("static") ? number("static", true) : law.coulomb;
            law.stribeck_speed = number("stribeck_speed", false);
            law.transition_speed = number("transition_speed", false);
            law.viscous = number("viscous", true);
            return std::make_shared<JointFriction>(name, c, law);
          }};
}

}  // namespace flexura::mbs
