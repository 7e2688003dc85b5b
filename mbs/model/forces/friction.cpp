// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/forces/friction.hpp"

#include <iterator>

namespace flexura::mbs {

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

double read_size(const input::Section& s, const ReadContext& context, const char* key, bool may_vanish) {
  const double x = context.number(s, key);
  if (x < 0.0 || (x == 0.0 && !may_vanish))
    s.refuse(key, may_vanish ? "must not be negative" : "must be above 0");
  return x;
}

FrictionLaw read_friction(const input::Section& s, const ReadContext& context, FrictionLimits limits) {
  FrictionLaw law;
  law.coulomb = read_size(s, context, "coulomb", true);
  law.static_force =
      s.has("static") ? read_size(s, context, "static", limits.static_may_vanish) : law.coulomb;
  law.stribeck_speed = read_size(s, context, "stribeck_speed", limits.stribeck_may_vanish);
  law.viscous = read_size(s, context, "viscous", true);
  return law;
}

}  // namespace flexura::mbs
