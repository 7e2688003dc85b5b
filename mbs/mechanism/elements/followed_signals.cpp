// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/elements/followed_signals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mbs/mechanism/elements/directional.hpp"

namespace flexura::mbs {

FollowedSignals::FollowedSignals(const Topology& tree, const ElementStates& states,
                                 const ConstraintRows& rows)
    : tree_(tree), states_(states), order_(static_cast<std::size_t>(tree.d.signals.size()), -1) {
  for (std::size_t k = 0; k < rows.constraints().size(); ++k)
    for (int i = 0; i < rows.constraints()[k]->n_followed(); ++i)
      if (const Following what = rows.constraints()[k]->following(i); what.formula)
        followers_.push_back({k, rows.first_followed(k) + static_cast<std::size_t>(i), what});
  for (const Follower& follower : followers_) {
    check(follower);
    for (const int place : follower.what.formula->reads())
      need(place, follower.what.level == DriveLevel::position ? 2 : 1);
  }
  list_places();
}

void FollowedSignals::size(FollowedValues& values) const {
  if (!any()) return;
  values.signals.assign(order_.size(), Jet{});
  values.c_rate.setZero(tree_.n_dyn);
  values.c_rate_2.setZero(tree_.n_dyn);
  values.seen.setZero(static_cast<Eigen::Index>(order_.size()));
}

void FollowedSignals::check(const Follower& follower) const {
  const Expression& f = *follower.what.formula;
  std::vector<int> seen(order_.size(), 0), list;
  for (const int place : f.reads()) order_by_reads(place, seen, list);
  const auto refuse = [&](const std::string& why, const std::string& remedy) {
    throw std::invalid_argument(fmt::format("{} = \"{}\": {}; {}", f.where(), f.text(), why, remedy));
  };
  for (const int place : list)
    if (const Control* const control = algebraic(place); control && !control->equation())
      refuse(fmt::format("\"{}\" is an algebraic state without a formula", tree_.d.signals.names()[place]),
             "put a control of type filter between");
  const bool of_position = follower.what.level == DriveLevel::position;
  if (of_position) {
    for (const int node : f.conditions())
      if (!f.is_kink(node))
        refuse("the formula jumps with the motion, and no position can",
               "lead it over with step(x, x_0, y_0, x_1, y_1), or put it into the rate of a control of type "
               "state");
    for (const int place : f.reads()) {
      if (jumps(place))
        refuse(fmt::format("\"{}\" jumps where it switches, and no position can",
                           tree_.d.signals.names()[place]),
               "put a control of type filter behind it, or drive the speed");
      if (const auto on = find_dependent(place))
        refuse(fmt::format("a position can follow time, inputs, states of controls and algebraic states of "
                           "these, and \"{}\" is {}",
                           on->name, on->why),
               "hold a formula of coordinates and signals by a constraint (type = \"expression\"), put a "
               "control of type "
               "filter between, or drive the speed");
    }
  }
  for (const int place : f.reads())
    if (const auto unknown = find_unknown(place, of_position ? 2 : 1))
      refuse(fmt::format("the {} that a {} has to follow is not known before the forces: it reads \"{}\", {}",
                         of_position ? "acceleration" : "rate", of_position ? "position" : "speed",
                         unknown->name, unknown->why),
             of_position ? "put a control of type filter between, or drive the speed"
                         : "put a control of type filter between");
}

bool FollowedSignals::jumps(int place) const {
  const auto& source = states_.sources()[place];
  if (source.kind == Kind::control && tree_.d.controls[source.element]->n_switches() > 0) return true;
  const Expression* formula = source.kind == Kind::measure ? tree_.d.measures[source.element]->formula()
                              : algebraic(place)           ? algebraic(place)->equation()
                                                           : nullptr;
  if (!formula) return false;
  return std::ranges::any_of(formula->conditions(), [&](int node) { return !formula->is_kink(node); }) ||
         std::ranges::any_of(made_of(place), [&](int k) { return jumps(k); });
}

// What is no function of c and t alone.
std::optional<FollowedSignals::Unknown> FollowedSignals::find_dependent(int place) const {
  const auto& source = states_.sources()[place];
  const std::string& name = tree_.d.signals.names()[place];
  switch (source.kind) {
    case Kind::time:
    case Kind::input:
      return {};
    case Kind::coordinate:
      return Unknown{name, "a coordinate"};
    case Kind::speed:
      return Unknown{name, "a speed"};
    case Kind::measure: {
      const Expression* formula = tree_.d.measures[source.element]->formula();
      if (!formula) return Unknown{name, "a measure of the motion"};
      for (const int k : formula->reads())
        if (auto found = find_dependent(k)) return found;
      return {};
    }
    case Kind::control: {
      const Control& control = *tree_.d.controls[source.element];
      if (control.is_algebraic()) {
        for (const int k : made_of(place))
          if (const auto found = find_dependent(k))
            return Unknown{
                name, fmt::format("an algebraic state that depends on \"{}\", {}", found->name, found->why)};
        return {};
      }
      if (control.feeds_through())
        return Unknown{name, fmt::format("a {} that passes on what it reads", control.type())};
      return {};
    }
  }
  return {};
}

std::optional<FollowedSignals::Unknown> FollowedSignals::find_unknown(int place, int order) const {
  if (order <= 0) return {};
  const auto& source = states_.sources()[place];
  const std::string& name = tree_.d.signals.names()[place];
  const auto of_reads = [&](const std::vector<int>& reads, int at) -> std::optional<Unknown> {
    for (const int k : reads)
      if (auto found = find_unknown(k, at)) return found;
    return {};
  };
  switch (source.kind) {
    case Kind::time:
    case Kind::input:
      return {};
    case Kind::coordinate:
      if (order == 1) return {};
      return Unknown{name, "a coordinate, without a state between"};
    case Kind::speed:
      return Unknown{name, "a speed, whose rate is an acceleration"};
    case Kind::measure: {
      const Measure& measure = *tree_.d.measures[source.element];
      if (measure.formula()) return of_reads(measure.formula()->reads(), order);
      if (order == 1 && measure.is_of_positions()) return {};
      if (measure.is_only_shown()) return Unknown{name, "an acceleration or reaction"};
      return Unknown{name, measure.is_of_positions() ? "a measure of positions, without a state between"
                                                     : "a measure of speeds, whose rate is an acceleration"};
    }
    case Kind::control: {
      const Control& control = *tree_.d.controls[source.element];
      if (control.is_algebraic()) return of_reads(made_of(place), order);
      if (control.n_switches() > 0) return {};  // constant between its switches
      return of_reads(control.reads(), order - control.relative_degree());
    }
  }
  return {};
}

void FollowedSignals::need(int place, int order) {
  int& known = order_[static_cast<std::size_t>(place)];
  if (order <= known) return;
  known = order;
  const auto& source = states_.sources()[place];
  for (const int k : made_of(place)) need(k, order);
  if (source.kind != Kind::control) return;
  const Control& control = *tree_.d.controls[source.element];
  if (control.is_algebraic() || control.n_switches() > 0) return;
  for (const int k : control.reads()) need(k, std::max(order - control.relative_degree(), 0));
}

std::vector<int> FollowedSignals::made_of(int place) const {
  const auto& source = states_.sources()[place];
  if (source.kind == Kind::measure) return tree_.d.measures[source.element]->reads();
  if (source.kind != Kind::control) return {};
  const Control& control = *tree_.d.controls[source.element];
  if (!control.is_algebraic() && !control.feeds_through()) return {};
  std::vector<int> reads = control.reads();
  std::erase(reads, place);
  return reads;
}

const Control* FollowedSignals::algebraic(int place) const {
  const auto& source = states_.sources()[place];
  if (source.kind != Kind::control || !tree_.d.controls[source.element]->is_algebraic()) return nullptr;
  return tree_.d.controls[source.element].get();
}

// `state` of each signal: 0 not seen yet, 1 on the way, 2 in the list.
void FollowedSignals::order_by_reads(int place, std::vector<int>& state, std::vector<int>& list) const {
  int& own = state[static_cast<std::size_t>(place)];
  if (own == 2) return;
  if (own == 1)
    throw std::invalid_argument(
        fmt::format("\"{}\" is an algebraic state that depends on itself through others, and is followed by "
                    "a drive or a constraint, "
                    "which may follow what one equation determines; put the equations into one",
                    tree_.d.signals.names()[place]));
  own = 1;
  for (const int k : made_of(place)) order_by_reads(k, state, list);
  own = 2;
  list.push_back(place);
}

void FollowedSignals::list_places() {
  std::vector<int> in_positions(order_.size(), 0), in_any = in_positions;
  for (const Follower& follower : followers_)
    for (const int place : follower.what.formula->reads())
      if (follower.what.level == DriveLevel::position) order_by_reads(place, in_positions, of_states_);
  for (const int k : states_.used_signals())
    if (order_[static_cast<std::size_t>(k)] >= 0) order_by_reads(k, in_any, places_);
  // What a rate reads alone is there, but nothing of it need be known.
  std::erase_if(places_, [&](int k) { return order_[static_cast<std::size_t>(k)] < 0; });
  eliminates_ = std::ranges::any_of(places_, [&](int k) { return algebraic(k) != nullptr; });
}

// An algebraic state by Newton's method from the value that it has, which stays where there is no root.
void FollowedSignals::evaluate_place(int place, const Motion& motion, Signals& signals) const {
  const Control* control = algebraic(place);
  if (!control) {
    if (place > 0) states_.evaluate_signal(place, motion, signals);
    return;
  }
  const Expression& b = *control->equation();
  const double start = states_.control_output(states_.sources()[place].element, motion, signals);
  double& a = signals.values(place);
  a = start;
  constexpr int kMostSteps = 100;
  double left = std::abs(b.evaluate(signals.values.data()));
  for (int i = 0; i < kMostSteps && left > 0.0; ++i) {
    const double from = a;
    double step = -b.evaluate(signals.values.data()) / b.derivative(signals.values.data(), place),
           next = left;
    if (!std::isfinite(step) || std::abs(step) <= std::numeric_limits<double>::epsilon() * std::abs(from))
      break;
    // Halved where the whole step leads away; where none leads nearer all is done.
    for (int half = 0; half < 40; ++half, step *= 0.5) {
      a = from + step;
      next = std::abs(b.evaluate(signals.values.data()));
      if (next < left) break;
    }
    if (!(next < left)) {
      a = from;
      break;
    }
    left = next;
  }
  const double per_unit = std::abs(b.derivative(signals.values.data(), place));
  constexpr double kRoot = 1e-9;
  if (!(left <= kRoot * per_unit * std::max(1.0, std::abs(a)))) a = start;
}

double FollowedSignals::rate_of_coordinate(CoordinateRef c, const Motion& motion) const {
  const JointPlace& place = tree_.places[c.joint];
  if (!place.in_tree()) return motion.kin.speed(c);  // angles and lengths, whose rates these are
  double q_dot[7];
  place.joint->kinematic(motion.kin.p + place.i_p, motion.kin.v + place.i_v, q_dot);
  return q_dot[c.index];
}

void FollowedSignals::output_weights(int control, const Motion& motion, const Signals& signals,
                                     Eigen::VectorXd& weights) const {
  const Control& c = *tree_.d.controls[control];
  weights.setZero(c.n_states());
  StateWeights collect(weights);
  c.differentiate(signals.values.data(), motion.kin.c + states_.first_state_of_control(control), collect);
}

void FollowedSignals::first_derivatives(bool all, Motion& motion, const Signals& signals,
                                        FollowedValues& values) const {
  for (std::size_t k = 0; k < order_.size(); ++k)
    values.signals[k] = {signals.values(static_cast<Eigen::Index>(k)), 0.0, 0.0};
  values.signals[0].first = 1.0;
  for (const int place : places_) {
    const int order = order_[static_cast<std::size_t>(place)];
    if (order < (all ? 1 : 2)) continue;
    Jet& jet = values.signals[static_cast<std::size_t>(place)];
    const auto& source = states_.sources()[place];
    AlongMotion along(motion, values);
    switch (source.kind) {
      case Kind::time:
      case Kind::speed:
        break;
      case Kind::coordinate:
        jet.first = rate_of_coordinate(source.coordinate, motion);
        break;
      case Kind::input: {
        const Jet of_time = tree_.d.inputs[source.element].value->time_derivatives(motion.kin.t);
        const Eigen::Index at = static_cast<Eigen::Index>(tree_.d.inputs.size()) + source.element;
        jet.first = of_time.first + signals.inputs(at);
        jet.second = of_time.second + signals.inputs(at + static_cast<Eigen::Index>(tree_.d.inputs.size()));
        break;
      }
      case Kind::measure:
        tree_.d.measures[source.element]->differentiate(motion.kin, signals.values.data(), along);
        jet.first = along.change();
        break;
      case Kind::control: {
        const Control& control = *tree_.d.controls[source.element];
        if (control.is_algebraic()) {
          const Expression& b = *control.equation();
          jet.first = -b.along(signals.values.data(), values.signals.data()).first /
                      b.derivative(signals.values.data(), place);
          break;
        }
        const int first = states_.first_state_of_control(source.element);
        control.rates(signals.values.data(), motion.kin.c + first, values.c_rate.data() + first);
        along.set_states(values.c_rate.data() + first);
        control.differentiate(signals.values.data(), motion.kin.c + first, along);
        jet.first = along.change();
      }
    }
  }
}

void FollowedSignals::second_derivatives(const Motion& motion, const Signals& signals,
                                         FollowedValues& values) const {
  for (const int place : places_) {
    if (order_[static_cast<std::size_t>(place)] < 2) continue;
    Jet& jet = values.signals[static_cast<std::size_t>(place)];
    const auto& source = states_.sources()[place];
    if (source.kind == Kind::measure) {
      if (const Expression* formula = tree_.d.measures[source.element]->formula())
        jet = formula->along(signals.values.data(), values.signals.data());
      continue;
    }
    if (source.kind != Kind::control) continue;
    const Control& control = *tree_.d.controls[source.element];
    if (control.is_algebraic()) {
      const Expression& b = *control.equation();
      jet.second = -b.along(signals.values.data(), values.signals.data()).second /
                   b.derivative(signals.values.data(), place);
      continue;
    }
    const int first = states_.first_state_of_control(source.element);
    AlongMotion along(motion, values);
    values.c_rate_2.segment(first, control.n_states()).setZero();
    along.set_states(values.c_rate.data() + first);
    along.set_rates(values.c_rate_2.data() + first);
    control.differentiate_rates(signals.values.data(), motion.kin.c + first, along);
    // Outputs are linear in the states.
    AlongMotion output(motion, values);
    output.set_states(values.c_rate_2.data() + first);
    control.differentiate(signals.values.data(), motion.kin.c + first, output);
    jet.second = output.change();
  }
}

void FollowedSignals::evaluate(Level level, Motion& motion, Signals& signals, RowValues& rows) const {
  if (!any()) return;
  FollowedValues& values = rows.followed;
  if (level == Level::position) {
    signals.values(0) = motion.kin.t;
    for (const int k : of_states_) evaluate_place(k, motion, signals);
  } else {
    if (eliminates_) {
      values.seen = signals.values;
      for (const int k : places_) evaluate_place(k, motion, signals);
    }
    first_derivatives(level == Level::acceleration, motion, signals, values);
    if (level == Level::acceleration) second_derivatives(motion, signals, values);
  }
  for (const Follower& follower : followers_) {
    const Expression& f = *follower.what.formula;
    Jet& y = values.of_constraints[follower.place];
    const bool of_position = follower.what.level == DriveLevel::position;
    if (level == Level::acceleration || (level == Level::velocity && of_position))
      y = f.along(signals.values.data(), values.signals.data());
    else if (level == Level::velocity || of_position)
      y = {f.evaluate(signals.values.data()), 0.0, 0.0};
  }
  if (eliminates_ && level != Level::position) signals.values = values.seen;
}

}  // namespace flexura::mbs
