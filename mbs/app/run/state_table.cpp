// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/state_table.hpp"

#include <algorithm>
#include <cmath>

#include "mbs/base/terminal/terminal.hpp"
#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/accuracy/scales.hpp"
#include "mbs/solver/position/openings.hpp"

namespace flexura::app {
namespace {

// Sums of some tens of terms in double precision lose no more than this of the largest.
constexpr double kRoundOff = 1e-13;

std::string with_unit(const std::string& name, const std::string& unit) {
  return name + " [" + (unit.empty() ? "-" : unit) + "]";
}

}  // namespace

StateText::StateText(const mbs::PreparedMechanism& prepared) : p_(prepared) {
  const mbs::Mechanism& m = *p_.mechanism;
  for (const mbs::OutputInfo& info : m.quantities()) units_.emplace_back(info.name, mbs::unit_of(info));
  std::ranges::sort(units_);
  const mbs::Scales* scales = p_.options.scales.get();
  length_ = scales ? std::max(scales->length, scales->farthest) : 1.0;
  const auto fastest = [&](const Eigen::VectorXd& x) {
    double most = 0.0;
    for (Eigen::Index i = 0; i < x.size(); ++i)
      most = std::max(most, std::abs(x(i)) * (scales ? scales->reach_v(i) : 1.0));
    return most;
  };
  const double gravity = m.description().gravity.norm();
  speed_ = std::max(fastest(p_.state.v), std::sqrt(gravity * length_));
  acceleration_ = std::max({fastest(p_.v_dot), gravity, length_ > 0.0 ? speed_ * speed_ / length_ : 0.0});
  multiplier_ = p_.state.lambda.size() > 0 ? p_.state.lambda.cwiseAbs().maxCoeff() : 0.0;
}

std::string StateText::unit_of(const std::string& name) const {
  const auto found = std::ranges::lower_bound(units_, name, {}, &std::pair<std::string, std::string>::first);
  return found != units_.end() && found->first == name ? found->second : "";
}

std::string StateText::position_name(int i) const {
  const std::string name = p_.mechanism->name_of_position(i);
  return with_unit(name, unit_of(name));
}

std::string StateText::velocity_name(int i) const {
  const std::string name = p_.mechanism->name_of_velocity(i);
  // Rates of modal coordinates are no quantities of their own.
  const std::string rate = "_rate";
  if (name.ends_with(rate)) {
    const std::string of = unit_of(name.substr(0, name.size() - rate.size()));
    return with_unit(name, of.empty() ? "1/s" : of + "/s");
  }
  return with_unit(name, unit_of(name));
}

std::string StateText::multiplier_name(int i) const {
  return with_unit(p_.mechanism->name_of_constraint(i), mbs::force_unit_of(*p_.mechanism, i));
}

std::string StateText::other_name(const std::string& name) const {
  const std::string unit = unit_of(name);
  return unit.empty() ? name : with_unit(name, unit);
}

std::string StateText::position(int i, int digits) const {
  const double value = p_.state.p(i), reach = p_.options.scales ? p_.options.scales->reach_p(i) : 1.0;
  return terminal::number(std::abs(value) * reach < kRoundOff * length_ ? 0.0 : value, digits);
}

std::string StateText::velocity(int i, int digits) const {
  const double value = p_.state.v(i), reach = p_.options.scales ? p_.options.scales->reach_v(i) : 1.0;
  return terminal::number(std::abs(value) * reach < kRoundOff * speed_ ? 0.0 : value, digits);
}

std::string StateText::acceleration(int i, int digits) const {
  const double value = p_.v_dot(i), reach = p_.options.scales ? p_.options.scales->reach_v(i) : 1.0;
  return terminal::number(std::abs(value) * reach < kRoundOff * acceleration_ ? 0.0 : value, digits);
}

std::string StateText::multiplier(int i, int digits) const {
  const double value = p_.state.lambda(i);
  return terminal::number(std::abs(value) < kRoundOff * multiplier_ ? 0.0 : value, digits);
}

}  // namespace flexura::app
