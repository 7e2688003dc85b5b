// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/watch/creep_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/forces/contacts/contact.hpp"
#include "mbs/forces/joint_friction.hpp"

namespace flexura::app {

namespace {

// In transition speeds: tanh(4) = 0.9993 of the greatest force. Slower than kAtRest there is next to no load.
constexpr double kSticks = 4.0, kAtRest = 0.02;
constexpr double kTold = 0.01;  // of the way made

}  // namespace

CreepWatch::CreepWatch(const mbs::Mechanism& mechanism)
    : mechanism_(mechanism), scratch_(mechanism.make_scratch()) {
  const mbs::MechanismDescription& d = mechanism.description();
  std::vector<std::string> names;  // of the quantities, two for each
  for (const auto& force : d.forces) {
    if (const auto* joint = dynamic_cast<const mbs::JointFriction*>(force.get())) {
      const mbs::CoordinateRef c = joint->coordinates().front();
      const mbs::CoordinateInfo speed = d.joints[static_cast<std::size_t>(c.joint)].joint->speeds()[c.index];
      frictions_.push_back(
          {.name = force->name(),
           .unit = speed.dimension == input::dim::velocity ? "m" : "rad",
           .remedy = "type = \"stick_slip\" sticks, and a smaller transition_speed creeps less",
           .transition_speed = joint->transition_speed(),
           .is_contact = false});
      names.push_back(d.joints[static_cast<std::size_t>(c.joint)].name + "." + speed.name);
      names.push_back(names.back());
    } else if (const auto* contact = dynamic_cast<const mbs::Contact*>(force.get());
               contact && contact->has_friction()) {
      frictions_.push_back({.name = force->name(),
                            .unit = "m",
                            .remedy = "a smaller transition_speed creeps less",
                            .transition_speed = contact->transition_speed(),
                            .is_contact = true});
      names.push_back(force->name() + ".sliding_speed");
      names.push_back(force->name() + ".normal_force");
    }
  }
  if (frictions_.empty()) return;
  const std::vector<mbs::OutputInfo> quantities = mechanism.quantities();
  for (const std::string& name : names)
    which_.push_back(
        static_cast<int>(std::ranges::find(quantities, name, &mbs::OutputInfo::name) - quantities.begin()));
  now_.resize(static_cast<Eigen::Index>(which_.size()));
}

void CreepWatch::observe(const mbs::State& s, const Eigen::VectorXd& v_dot) {
  if (which_.empty()) return;
  mechanism_.evaluate(which_, s, v_dot, *scratch_, now_);
  const double h = s.t - t_before_;
  for (std::size_t k = 0; k < frictions_.size() && before_.size() > 0; ++k) {
    Friction& f = frictions_[k];
    const auto i = static_cast<Eigen::Index>(2 * k);
    if (f.is_contact && !(before_(i + 1) > 0.0 && now_(i + 1) > 0.0)) continue;
    const double u = std::abs(before_(i)), v = std::abs(now_(i)), way = 0.5 * h * (u + v);
    f.way += way;
    if (std::max(u, v) > kSticks * f.transition_speed || std::min(u, v) < kAtRest * f.transition_speed)
      continue;
    f.crept += way;
    f.time += h;
    f.fastest = std::max({f.fastest, u, v});
  }
  t_before_ = s.t;
  before_ = now_;
}

std::vector<std::string> CreepWatch::sentences() const {
  std::vector<std::string> out;
  for (const Friction& f : frictions_)
    if (f.crept > kTold * f.way)
      out.push_back(
          fmt::format("friction \"{}\" creeps where it would stick: {:.2g} {} in {:.3g} s, at up to {:.2g} "
                      "{}/s (transition_speed "
                      "{:g}); {}",
                      f.name, f.crept, f.unit, f.time, f.fastest, f.unit, f.transition_speed, f.remedy));
  return out;
}

}  // namespace flexura::app
