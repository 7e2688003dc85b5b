// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/elements/element_states.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "mbs/formulas/operations.hpp"

namespace flexura::mbs {

ElementStates::ElementStates(const Topology& tree) : tree_(tree) {
  // Where the signals come from, and which of them anything reads.
  sources_.resize(tree_.d.signals.size());
  std::vector<bool> is_used(tree_.d.signals.size(), false);
  for (std::size_t j = 0; j < tree_.d.joints.size(); ++j) {
    const std::string prefix = tree_.d.joints[j].name + ".";
    const auto link = [&](const std::vector<CoordinateInfo>& infos, SignalSource::Kind kind) {
      for (std::size_t i = 0; i < infos.size(); ++i)
        if (const int k = tree_.d.signals.find(prefix + infos[i].name); k >= 0)
          sources_[k] = {kind, {static_cast<int>(j), static_cast<int>(i)}, -1};
    };
    link(tree_.d.joints[j].joint->coordinates(), SignalSource::Kind::coordinate);
    link(tree_.d.joints[j].joint->speeds(), SignalSource::Kind::speed);
  }
  for (std::size_t i = 0; i < tree_.d.measures.size(); ++i)
    if (const int k = tree_.d.signals.find(tree_.d.measures[i]->name()); k >= 0)
      sources_[k] = {SignalSource::Kind::measure, {}, static_cast<int>(i)};
  for (std::size_t i = 0; i < tree_.d.inputs.size(); ++i)
    if (const int k = tree_.d.signals.find(tree_.d.inputs[i].name); k >= 0)
      sources_[k] = {SignalSource::Kind::input, {}, static_cast<int>(i)};
  first_state_ = {0};
  for (std::size_t i = 0; i < tree_.d.controls.size(); ++i) {
    first_state_.push_back(first_state_.back() + tree_.d.controls[i]->n_states());
    if (const int k = tree_.d.signals.find(tree_.d.controls[i]->name()); k >= 0)
      sources_[k] = {SignalSource::Kind::control, {}, static_cast<int>(i)};
  }
  first_force_state_ = {first_state_.back()};
  first_control_switch_ = {0};
  for (std::size_t i = 0; i < tree_.d.controls.size(); ++i) {
    first_control_switch_.push_back(first_control_switch_.back() + tree_.d.controls[i]->n_switches());
    if (tree_.d.controls[i]->is_algebraic()) algebraic_.push_back(static_cast<int>(i));
  }
  first_switch_ = {first_control_switch_.back()};
  for (const auto& force : tree_.d.forces) {
    first_force_state_.push_back(first_force_state_.back() + force->n_states());
    first_switch_.push_back(first_switch_.back() + force->n_switches());
  }
  const auto mark = [&](const std::vector<int>& reads) {
    for (int k : reads) is_used[k] = true;
  };
  for (const auto& force : tree_.d.forces) mark(force->reads());
  for (const auto& control : tree_.d.controls) mark(control->reads());
  for (const JointDescription& joint : tree_.d.joints)
    for (const auto* drives : {&joint.drives, &joint.speed_drives, &joint.acceleration_drives})
      for (const auto& [index, motion] : *drives) mark(motion->reads());
  for (const JointDescription& joint : tree_.d.joints)
    for (int i = 0; joint.rotation_drive && i < 3; ++i)
      mark(joint.rotation_drive->angles()[static_cast<std::size_t>(i)].formula()->reads());
  for (const auto& constraint : tree_.d.constraints)
    for (int i = 0; i < constraint->n_followed(); ++i)
      if (const Following what = constraint->following(i); what.formula) mark(what.formula->reads());
  // A measure reads only measures before it: backwards, so that what a used one needs is used too.
  for (std::size_t i = tree_.d.measures.size(); i-- > 0;)
    if (const int k = tree_.d.signals.find(tree_.d.measures[i]->name()); k >= 0 && is_used[k])
      mark(tree_.d.measures[i]->reads());
  for (std::size_t i = 0; i < tree_.d.measures.size(); ++i)
    if (const int k = tree_.d.signals.find(tree_.d.measures[i]->name());
        k >= 0 && is_used[k] && tree_.d.measures[i]->is_only_shown())
      coupled_measures_.push_back(static_cast<int>(i));
  list_conditions(is_used);
  list_curves();
  // Coordinates, outputs that depend on states alone, measures in their order, then what feeds through.
  const auto append = [&](auto&& wanted) {
    for (int k = 1; k < tree_.d.signals.size(); ++k)
      if (is_used[k] && wanted(sources_[k])) used_signals_.push_back(k);
  };
  using Kind = SignalSource::Kind;
  append([](const SignalSource& s) {
    return s.kind == Kind::coordinate || s.kind == Kind::speed || s.kind == Kind::input;
  });
  append([&](const SignalSource& s) {
    return s.kind == Kind::control && !tree_.d.controls[s.element]->feeds_through();
  });
  append([](const SignalSource& s) { return s.kind == Kind::measure; });
  append([&](const SignalSource& s) {
    return s.kind == Kind::control && tree_.d.controls[s.element]->feeds_through();
  });
}

int ElementStates::coupled_measure(int measure) const {
  const auto found = std::ranges::find(coupled_measures_, measure);
  return found == coupled_measures_.end() ? -1 : static_cast<int>(found - coupled_measures_.begin());
}

void ElementStates::size(int n_contacts, Signals& signals) const {
  signals.values.setZero(tree_.d.signals.size());
  signals.switches.assign(n_switches(), 0);
  signals.algebraic.setZero(n_algebraic() + n_contacts);
  signals.inputs.setZero(3 * static_cast<Eigen::Index>(tree_.d.inputs.size()));
}

void ElementStates::start(State& s, int n_contacts) const {
  s.c.setZero(tree_.n_dyn);
  for (std::size_t i = 0; i < tree_.d.controls.size(); ++i)
    tree_.d.controls[i]->start(s.c.data() + first_state_[i]);
  for (std::size_t i = 0; i < tree_.d.forces.size(); ++i)
    tree_.d.forces[i]->start(s.c.data() + first_force_state_[i]);
  s.a.setZero(n_algebraic() + n_contacts);
  for (std::size_t k = 0; k < algebraic_.size(); ++k)
    s.a(static_cast<Eigen::Index>(k)) = tree_.d.controls[algebraic_[k]]->start_algebraic();
  for (std::size_t k = 0; k < coupled_measures_.size(); ++k)
    s.a(static_cast<Eigen::Index>(algebraic_.size() + k)) = tree_.d.measures[coupled_measures_[k]]->guess();
  s.root.assign(n_switches(), 0);
}

void ElementStates::take_states(const State& s, Motion& motion, Signals& signals) const {
  motion.kin.c = s.c.data();
  // A caller that knows nothing of switches has them all off.
  for (std::size_t i = 0; i < signals.switches.size(); ++i)
    signals.switches[i] = i < s.root.size() ? s.root[i] : 0;
  for (std::size_t i = 0; i < conditions_.size(); ++i)
    signals.values(conditions_[i].place) =
        signals.switches[static_cast<std::size_t>(first_switch_.back()) + i];
  signals.inputs.setZero();
  signals.inputs.head(s.u.size()) = s.u;
  if (s.a.size() == signals.algebraic.size()) signals.algebraic = s.a;
}

double ElementStates::control_output(int control, const Motion& motion, const Signals& signals) const {
  const Control& c = *tree_.d.controls[control];
  if (!c.is_algebraic()) return c.output(signals.values.data(), motion.kin.c + first_state_[control]);
  return signals.algebraic(std::ranges::find(algebraic_, control) - algebraic_.begin());
}

double ElementStates::input_now(int input, const Motion& motion, const Signals& signals) const {
  return tree_.d.inputs[input].value->evaluate(&motion.kin.t) + signals.inputs(input);
}

void ElementStates::algebraic_equations(const Signals& signals, VectorRef b) const {
  for (std::size_t k = 0; k < algebraic_.size(); ++k)
    b(static_cast<Eigen::Index>(k)) = tree_.d.controls[algebraic_[k]]->residual(signals.values.data());
}

void ElementStates::own_states(std::size_t force, Motion& motion, const Signals& signals) const {
  motion.kin.own.c = motion.kin.c + first_force_state_[force];
  motion.kin.own.root = signals.switches.data() + first_switch_[force];
}

void ElementStates::evaluate_signals(Motion& motion, Signals& signals) const {
  signals.values(0) = motion.kin.t;
  for (int k : used_signals_) evaluate_signal(k, motion, signals);
}

void ElementStates::evaluate_signal(int k, const Motion& motion, Signals& signals) const {
  const SignalSource& source = sources_[k];
  switch (source.kind) {
    case SignalSource::Kind::time:
      break;
    case SignalSource::Kind::coordinate:
      signals.values(k) = motion.kin.coordinate(source.coordinate);
      break;
    case SignalSource::Kind::speed:
      signals.values(k) = motion.kin.speed(source.coordinate);
      break;
    case SignalSource::Kind::input:
      signals.values(k) = input_now(source.element, motion, signals);
      break;
    case SignalSource::Kind::control:
      signals.values(k) = control_output(source.element, motion, signals);
      break;
    case SignalSource::Kind::measure:
      if (const int i = coupled_measure(source.element); i >= 0)
        signals.values(k) = signals.algebraic(static_cast<Eigen::Index>(algebraic_.size()) + i);
      else
        signals.values(k) = tree_.d.measures[source.element]->value(motion.kin, signals.values.data());
      break;
  }
}

void ElementStates::roots(Motion& motion, const Signals& signals, VectorRef values) const {
  for (std::size_t i = 0; i < tree_.d.controls.size(); ++i)
    if (tree_.d.controls[i]->n_switches() > 0)
      tree_.d.controls[i]->switching(signals.values.data(), motion.kin.c + first_state_[i],
                                     values.data() + first_control_switch_[i]);
  for (std::size_t i = 0; i < tree_.d.forces.size(); ++i) {
    if (tree_.d.forces[i]->n_switches() == 0) continue;
    own_states(i, motion, signals);
    tree_.d.forces[i]->switching(motion.kin, signals.values.data(), values.data() + first_switch_[i]);
  }
  for (int i = 0; i < first_switch_.back(); ++i)
    if (std::isnan(values(i)))
      throw std::runtime_error(
          fmt::format("the switching function of \"{}\" is not a number at t = {:.9g} s; it must be one "
                      "wherever the motion leads",
                      name_of_root(i), motion.kin.t));
  for (std::size_t i = 0; i < conditions_.size(); ++i)
    values(first_switch_.back() + static_cast<int>(i)) =
        conditions_[i].formula->switching(conditions_[i].node, signals.values.data());
}

void ElementStates::list_conditions(const std::vector<bool>& is_used) {
  // Inputs, and measures that are formulas of time, inputs and each other.
  std::map<int, const FormulaTree*> of_time;
  std::vector<const Expression*> idle;
  for (const InputDescription& input : tree_.d.inputs)
    if (const int k = tree_.d.signals.find(input.name); k >= 0) of_time[k] = &input.value->tree();
  for (const auto& measure : tree_.d.measures) {
    const int k = tree_.d.signals.find(measure->name());
    const Expression* formula = measure->formula();
    if (!formula || k < 0) continue;
    if (!is_used[static_cast<std::size_t>(k)]) idle.push_back(formula);
    if (std::ranges::all_of(formula->reads(), [&](int place) { return of_time.contains(place); }))
      of_time[k] = &formula->tree();
  }
  const TimeFunction::Source source = [&](int place) {
    const auto found = of_time.find(place);
    return found == of_time.end() ? nullptr : found->second;
  };
  // Accelerations and reactions between steps are known less well than motions, so that an event found by them need not
  // be one where they are solved for anew.  A kink needs none: steps follow it as they can.
  std::set<int> of_reactions;
  for (std::size_t i = 0; i < tree_.d.measures.size(); ++i) {
    const std::vector<int> reads = tree_.d.measures[i]->reads();
    const int k = tree_.d.signals.find(tree_.d.measures[i]->name());
    if (k >= 0 && (coupled_measure(static_cast<int>(i)) >= 0 ||
                   std::ranges::any_of(reads, [&](int place) { return of_reactions.contains(place); })))
      of_reactions.insert(k);
  }
  std::set<std::string> known;
  for (const FormulaDescription& f : tree_.d.formulas) {
    // What only the results show moves nothing.
    if (std::ranges::find(idle, f.expression.get()) != idle.end()) continue;
    const FormulaTree& tree = f.expression->tree();
    constexpr double kLargest = 1e5;
    if (const double size = TimeFunction::size(tree, source); size > kLargest)
      throw std::invalid_argument(
          fmt::format("{}: is of {:.3g} parts with the measures and inputs that it reads put in, {:g} are "
                      "allowed; let them read "
                      "one another less often",
                      f.expression->where(), size, kLargest));
    for (const int part : TimeFunction::parts(tree, source)) {
      auto function =
          std::make_shared<const TimeFunction>(f.expression->where(), f.drives, tree, part, source);
      if (known.insert(function->fingerprint()).second) functions_of_time_.push_back(std::move(function));
    }
    const bool reads_motion =
        std::ranges::any_of(f.expression->reads(), [&](int k) { return !of_time.contains(k); });
    if (reads_motion && MotionFunction::may_peak(tree))
      functions_of_motion_.push_back(std::make_shared<const MotionFunction>(*f.expression));
    int number = 0;
    for (const int node : f.expression->conditions()) {
      ++number;
      // What depends on time alone is known beforehand, and needs no watching.
      const bool watched = tree.any(node, [&](const FormulaNode& n) {
        return n.code == operations::signal && n.place > 0 && !of_time.contains(n.place);
      });
      const bool bends_by_reactions =
          f.expression->is_kink(node) && tree.any(node, [&](const FormulaNode& n) {
            return n.code == operations::signal && of_reactions.contains(n.place);
          });
      if (watched && !bends_by_reactions)
        conditions_.push_back({f.expression, node, tree[node].held, number});
    }
  }
}

void ElementStates::list_curves() {
  for (const auto& force : tree_.d.forces)
    for (CurveLaw& law : force->curves()) {
      const int place = tree_.d.signals.size() + static_cast<int>(curves_.size());
      functions_of_motion_.push_back(std::make_shared<const MotionFunction>(force->name(), law.curve, place));
      curves_.push_back(std::move(law));
    }
}

void ElementStates::arguments_of_motion(const Motion& motion, const Signals& signals,
                                        Eigen::VectorXd& x) const {
  x.resize(signals.values.size() + static_cast<Eigen::Index>(curves_.size()));
  x.head(signals.values.size()) = signals.values;
  for (std::size_t i = 0; i < curves_.size(); ++i)
    x(signals.values.size() + static_cast<Eigen::Index>(i)) = curves_[i].argument(motion.kin);
}

void ElementStates::release_conditions(State& s) const {
  s.root.resize(static_cast<std::size_t>(n_switches()), 0);
  std::fill(s.root.begin() + first_switch_.back(), s.root.end(), 0);
}

void ElementStates::hold_conditions(State& s, const Signals& signals) const {
  const auto first = s.root.begin() + first_switch_.back();
  for (std::size_t i = 0; i < conditions_.size(); ++i)
    first[static_cast<long>(i)] =
        conditions_[i].formula->condition_now(conditions_[i].node, signals.values.data());
}

void ElementStates::change_switch(int which, State& s, Motion& motion, const Signals& signals) const {
  s.root.resize(n_switches(), 0);
  if (is_condition(which)) {
    const Condition& condition = conditions_[static_cast<std::size_t>(which - first_switch_.back())];
    s.root[static_cast<std::size_t>(which)] =
        condition.formula->condition_next(condition.node, signals.values.data());
    return;
  }
  std::size_t i = 0;
  if (which < first_control_switch_.back()) {
    while (first_control_switch_[i + 1] <= which) ++i;
    tree_.d.controls[i]->change_switch(which - first_control_switch_[i], signals.values.data(),
                                       s.c.data() + first_state_[i]);
    return;
  }
  while (first_switch_[i + 1] <= which) ++i;
  own_states(i, motion, signals);
  tree_.d.forces[i]->change_switch(which - first_switch_[i], motion.kin, signals.values.data(),
                                   s.root.data() + first_switch_[i], s.c.data() + first_force_state_[i]);
  return;
}

void ElementStates::start_switches(State& s,
                                   const std::function<std::pair<Motion&, const Signals&>()>& observe) const {
  s.root.assign(n_switches(), 0);
  // One after the other, as where they switch at one time later: what reads another sees what that has begun with.
  for (std::size_t i = 0; i < tree_.d.controls.size(); ++i)
    if (tree_.d.controls[i]->n_switches() > 0)
      tree_.d.controls[i]->start_switches(observe().second.values.data(), s.c.data() + first_state_[i]);
  if (std::ranges::none_of(tree_.d.forces, [](const auto& force) { return force->n_switches() > 0; })) return;
  const auto [motion, signals] = observe();
  for (std::size_t i = 0; i < tree_.d.forces.size(); ++i) {
    if (tree_.d.forces[i]->n_switches() == 0) continue;
    own_states(i, motion, signals);
    tree_.d.forces[i]->start_switches(motion.kin, signals.values.data(), s.root.data() + first_switch_[i],
                                      s.c.data() + first_force_state_[i]);
  }
}

bool ElementStates::is_kink(int root) const {
  if (!is_condition(root)) return false;
  const Condition& condition = conditions_[static_cast<std::size_t>(root - first_switch_.back())];
  return condition.formula->is_kink(condition.node);
}

bool ElementStates::jumps_at(int root) const {
  if (is_condition(root)) return !is_kink(root);
  if (root < first_control_switch_.back()) return true;
  std::size_t k = 0;
  while (first_switch_[k + 1] <= root) ++k;
  return tree_.d.forces[k]->jumps_at(root - first_switch_[k]);
}

std::string ElementStates::describe_root(int i) const {
  const Expression& formula = *conditions_[static_cast<std::size_t>(i - first_switch_.back())].formula;
  return fmt::format("a condition of {} = \"{}\"", formula.where(), formula.text());
}

std::string ElementStates::name_of_root(int i) const {
  if (is_condition(i)) {
    const Condition& condition = conditions_[static_cast<std::size_t>(i - first_switch_.back())];
    return fmt::format("{}.condition_{}", condition.formula->where(), condition.number);
  }
  std::size_t k = 0;
  if (i < first_control_switch_.back()) {
    while (first_control_switch_[k + 1] <= i) ++k;
    return tree_.d.controls[k]->name() + "." + tree_.d.controls[k]->switch_name(i - first_control_switch_[k]);
  }
  while (first_switch_[k + 1] <= i) ++k;
  return tree_.d.forces[k]->name() + "." + tree_.d.forces[k]->switch_name(i - first_switch_[k]);
}

std::string ElementStates::name_of_state(int i) const {
  if (i >= first_state_.back()) return name_of_force_state(i);
  std::size_t k = 0;
  while (first_state_[k + 1] <= i) ++k;
  const Control& control = *tree_.d.controls[k];
  if (control.n_states() == 1) return control.name();
  return fmt::format("{}.state_{}", control.name(), i - first_state_[k] + 1);
}

bool ElementStates::is_held(int i) const {
  std::size_t k = 0;
  if (i < first_state_.back()) {
    while (first_state_[k + 1] <= i) ++k;
    return tree_.d.controls[k]->is_held(i - first_state_[k]);
  }
  while (first_force_state_[k + 1] <= i) ++k;
  return tree_.d.forces[k]->is_held(i - first_force_state_[k]);
}

std::string ElementStates::name_of_force_state(int i) const {
  std::size_t k = 0;
  while (first_force_state_[k + 1] <= i) ++k;
  const ForceElement& force = *tree_.d.forces[k];
  if (force.n_states() == 1) return force.name();
  return fmt::format("{}.state_{}", force.name(), i - first_force_state_[k] + 1);
}

}  // namespace flexura::mbs
