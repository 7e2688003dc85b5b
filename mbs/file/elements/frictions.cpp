// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <iterator>

#include "mbs/file/elements/element_types.hpp"
#include "mbs/forces/joint_friction.hpp"
#include "mbs/forces/stick_slip.hpp"

/// Dry friction in a mechanism file.
namespace flexura::mbs {
namespace {

/// Which of the two limits may be 0.
struct FrictionLimits {
  bool static_may_vanish, stribeck_may_vanish;
};

/// The keys joint, coordinate, coulomb, static, stribeck_speed and viscous, then `own`.
std::vector<input::Key> friction_keys(std::vector<input::Key> own, const std::string& stribeck_doc) {
  using namespace input;
  std::vector<Key> keys = {
      text("joint", "the joint").required(),
      text("coordinate", "its coordinate, where it has more than one: \"angle\", \"position\", ..."),
      expression("coulomb", "friction at high speed").required(),
      expression("static", "greatest friction, at or near rest; without it that at high speed"),
      expression("stribeck_speed", stribeck_doc).or_default("0.01"),
      expression("viscous", "beside it, force per speed").or_default("0")};
  std::move(own.begin(), own.end(), std::back_inserter(keys));
  return keys;
}

/// A formula of parameters that must not be negative, nor 0 unless it `may_vanish`.
double read_size(const input::Section& s, const ReadContext& context, const char* key, bool may_vanish) {
  const double x = context.number(s, key);
  if (x < 0.0 || (x == 0.0 && !may_vanish))
    s.refuse(key, may_vanish ? "must not be negative" : "must be above 0");
  return x;
}

/// Refuses what is negative, and 0 where it may not be.
FrictionLaw read_friction(const input::Section& s, const ReadContext& context, FrictionLimits limits) {
  FrictionLaw law;
  law.coulomb = read_size(s, context, "coulomb", true);
  law.static_force =
      s.has("static") ? read_size(s, context, "static", limits.static_may_vanish) : law.coulomb;
  law.stribeck_speed = read_size(s, context, "stribeck_speed", limits.stribeck_may_vanish);
  law.viscous = read_size(s, context, "viscous", true);
  return law;
}

ForceType joint_friction() {
  using namespace input;
  return {
      "joint_friction",
      "Friction along a joint's coordinate by a smooth law with Stribeck effect. All in N, m/s or N m, "
      "rad/s.",
      friction_keys({expression("transition_speed", "speed over which the sign changes").or_default("0.001")},
                    "speed over which it falls"),
      {{"force", "N or N*m", "along the coordinate"}},
      [](const std::string& name, const Section& s,
         const ReadContext& context) -> std::shared_ptr<const ForceElement> {
        const CoordinateRef c = context.speed(s, "joint", "coordinate");
        const FrictionLaw law =
            read_friction(s, context, {.static_may_vanish = true, .stribeck_may_vanish = false});
        return std::make_shared<JointFriction>(name, c, law, read_size(s, context, "transition_speed", false),
                                               context.force_along(c));
      }};
}

ForceType stick_slip() {
  using namespace input;
  return {"stick_slip",
          "Friction along a joint's coordinate that truly sticks: a switch located by the integrator lets it "
          "go and catches it again. All in N, m/s or N m, rad/s.",
          friction_keys(
              {expression("stick_stiffness",
                          "of the spring that holds it while it sticks, N/m or N m/rad; it yields by "
                          "static / stick_stiffness")
                   .required(),
               expression("stick_damping", "beside that spring; without it critical for 1 kg or 1 kg m^2")},
              "speed over which sliding friction falls from one to the other; 0: at once"),
          {{"force", "N or N*m", "along the coordinate"}, {"sticks", "", "1 while it sticks, else 0"}},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const CoordinateRef c = context.speed(s, "joint", "coordinate");
            StickSlip::Law law = {
                read_friction(s, context, {.static_may_vanish = false, .stribeck_may_vanish = true}), 0.0,
                0.0};
            if (law.static_force < law.coulomb)
              s.refuse("static", "is below coulomb", "friction at rest is not smaller than in motion");
            law.stick_stiffness = read_size(s, context, "stick_stiffness", false);
            law.stick_damping = s.has("stick_damping") ? read_size(s, context, "stick_damping", true)
                                                       : 2.0 * std::sqrt(law.stick_stiffness);
            law.along = context.force_along(c);
            return std::make_shared<StickSlip>(name, c, law);
          }};
}

}  // namespace

std::vector<ForceType> friction_types() {
  return {joint_friction(), stick_slip()};
}

}  // namespace flexura::mbs
