// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "mbs/formulas/operations.hpp"
#include "mbs/formulas/time_function.hpp"
#include "mbs/mechanism/work.hpp"

/// Dynamic states and switches that belong to single elements.
namespace flexura::mbs {

void Mechanism::take_states(const State& s, Work& work) const {
  work.kin.c = s.c.data();
  // A caller that knows nothing of switches has them all off.
  for (std::size_t i = 0; i < work.switches.size(); ++i) work.switches[i] = i < s.root.size() ? s.root[i] : 0;
  for (std::size_t i = 0; i < conditions_.size(); ++i)
    work.signals(conditions_[i].place) = work.switches[static_cast<std::size_t>(first_switch_.back()) + i];
  if (s.u.size() == work.inputs.size())
    work.inputs = s.u;
  else
    work.inputs.setZero();
  if (s.a.size() != work.algebraic.size()) return;
  work.algebraic = s.a;
  for (std::size_t k = 0; k < contacts_.size(); ++k)
    work.contacts[contacts_[k]] = s.a(static_cast<Eigen::Index>(algebraic_.size() + k));
}

void Mechanism::own_contact(std::size_t constraint, Work& work) const {
  work.kin.own.contact = &work.contacts[constraint];
}

void Mechanism::start_contacts(State& s, Scratch& scratch) const {
  Work& work = work_of(scratch);
  forward(Level::position, s.t, s.p.data(), nullptr, nullptr, work);
  for (std::size_t k = 0; k < contacts_.size(); ++k)
    s.a(static_cast<Eigen::Index>(algebraic_.size() + k)) =
        constraints_[contacts_[k]]->start_contact(work.kin);
}

double Mechanism::control_output(int control, const Work& work) const {
  const Control& c = *d_.controls[control];
  if (!c.is_algebraic()) return c.output(work.signals.data(), work.kin.c + first_state_[control]);
  return work.algebraic(std::ranges::find(algebraic_, control) - algebraic_.begin());
}

double Mechanism::input_now(int input, const Work& work) const {
  return input_value(input, work.kin.t) + work.inputs(input);
}

void Mechanism::algebraic_equations(const Work& work, VectorRef b) const {
  for (std::size_t k = 0; k < algebraic_.size(); ++k)
    b(static_cast<Eigen::Index>(k)) = d_.controls[algebraic_[k]]->residual(work.signals.data());
  for (std::size_t k = 0; k < contacts_.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(algebraic_.size() + k);
    b(i) = constraints_[contacts_[k]]->contact_residual(work.kin, work.algebraic(i));
  }
}

void Mechanism::own_states(std::size_t force, Work& work) const {
  work.kin.own.c = work.kin.c + first_force_state_[force];
  work.kin.own.root = work.switches.data() + first_switch_[force];
}

void Mechanism::roots(const State& s, Scratch& scratch, VectorRef values) const {
  Work& work = work_of(scratch);
  forward(Level::velocity, s.t, s.p.data(), s.v.data(), nullptr, work);
  take_states(s, work);
  evaluate_signals(work);
  for (std::size_t i = 0; i < d_.controls.size(); ++i)
    if (d_.controls[i]->n_switches() > 0)
      d_.controls[i]->switching(work.signals.data(), work.kin.c + first_state_[i],
                                values.data() + first_control_switch_[i]);
  for (std::size_t i = 0; i < d_.forces.size(); ++i) {
    if (d_.forces[i]->n_switches() == 0) continue;
    own_states(i, work);
    d_.forces[i]->switching(work.kin, work.signals.data(), values.data() + first_switch_[i]);
  }
  for (std::size_t i = 0; i < conditions_.size(); ++i)
    values(first_switch_.back() + static_cast<int>(i)) =
        conditions_[i].formula->switching(conditions_[i].node, work.signals.data());
}

void Mechanism::list_conditions(const std::vector<bool>& is_used) {
  // Inputs, and measures that are formulas of time, inputs and each other.
  std::map<int, const FormulaTree*> of_time;
  std::vector<const Expression*> idle;
  for (const InputDescription& input : d_.inputs)
    if (const int k = d_.signals.find(input.name); k >= 0) of_time[k] = &input.value->tree();
  for (const auto& measure : d_.measures) {
    const int k = d_.signals.find(measure->name());
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
  std::set<std::string> known;
  for (const FormulaDescription& f : d_.formulas) {
    // What only the results show moves nothing.
    if (std::ranges::find(idle, f.expression.get()) != idle.end()) continue;
    const FormulaTree& tree = f.expression->tree();
    for (const int part : TimeFunction::parts(tree, source)) {
      auto function =
          std::make_shared<const TimeFunction>(f.expression->where(), f.drives, tree, part, source);
      if (known.insert(function->fingerprint()).second) functions_of_time_.push_back(std::move(function));
    }
    int number = 0;
    for (const int node : f.expression->conditions()) {
      ++number;
      // What depends on time alone is known beforehand, and needs no watching.
      const bool watched = tree.any(node, [&](const FormulaNode& n) {
        return n.code == operations::signal && n.place > 0 && !of_time.contains(n.place);
      });
      if (watched) conditions_.push_back({f.expression, node, tree[node].held, number});
    }
  }
}

void Mechanism::hold_conditions(State& s, Scratch& scratch) const {
  if (conditions_.empty()) return;
  s.root.resize(static_cast<std::size_t>(n_switches()), 0);
  const auto first = s.root.begin() + first_switch_.back();
  std::fill(first, s.root.end(), 0);
  Work& work = work_of(scratch);
  forward(Level::velocity, s.t, s.p.data(), s.v.data(), nullptr, work);
  take_states(s, work);
  evaluate_signals(work);
  for (std::size_t i = 0; i < conditions_.size(); ++i)
    first[static_cast<long>(i)] =
        conditions_[i].formula->condition_now(conditions_[i].node, work.signals.data());
}

bool Mechanism::on_root(int which, State& s, Scratch& scratch) const {
  Work& work = work_of(scratch);
  forward(Level::velocity, s.t, s.p.data(), s.v.data(), nullptr, work);
  take_states(s, work);
  evaluate_signals(work);
  s.root.resize(n_switches(), 0);
  if (is_condition(which)) {
    const Condition& condition = conditions_[static_cast<std::size_t>(which - first_switch_.back())];
    s.root[static_cast<std::size_t>(which)] =
        condition.formula->condition_next(condition.node, work.signals.data());
    return false;
  }
  std::size_t i = 0;
  if (which < first_control_switch_.back()) {
    while (first_control_switch_[i + 1] <= which) ++i;
    d_.controls[i]->change_switch(which - first_control_switch_[i], work.signals.data(),
                                  s.c.data() + first_state_[i]);
    return false;
  }
  while (first_switch_[i + 1] <= which) ++i;
  own_states(i, work);
  d_.forces[i]->change_switch(which - first_switch_[i], work.kin, work.signals.data(),
                              s.root.data() + first_switch_[i], s.c.data() + first_force_state_[i]);
  return false;
}

void Mechanism::start_switches(State& s, Scratch& scratch) const {
  Work& work = work_of(scratch);
  forward(Level::velocity, s.t, s.p.data(), s.v.data(), nullptr, work);
  take_states(s, work);
  evaluate_signals(work);
  s.root.assign(n_switches(), 0);
  for (std::size_t i = 0; i < d_.controls.size(); ++i)
    if (d_.controls[i]->n_switches() > 0)
      d_.controls[i]->start_switches(work.signals.data(), s.c.data() + first_state_[i]);
  for (std::size_t i = 0; i < d_.forces.size(); ++i) {
    if (d_.forces[i]->n_switches() == 0) continue;
    own_states(i, work);
    d_.forces[i]->start_switches(work.kin, work.signals.data(), s.root.data() + first_switch_[i],
                                 s.c.data() + first_force_state_[i]);
  }
  hold_conditions(s, scratch);
}

bool Mechanism::is_kink(int root) const {
  if (!is_condition(root)) return false;
  const Condition& condition = conditions_[static_cast<std::size_t>(root - first_switch_.back())];
  return condition.formula->is_kink(condition.node);
}

std::string Mechanism::describe_root(int i) const {
  if (!is_condition(i)) return Equations::describe_root(i);
  const Expression& formula = *conditions_[static_cast<std::size_t>(i - first_switch_.back())].formula;
  return fmt::format("a condition of {} = \"{}\"", formula.where(), formula.text());
}

std::string Mechanism::name_of_root(int i) const {
  if (is_condition(i)) {
    const Condition& condition = conditions_[static_cast<std::size_t>(i - first_switch_.back())];
    return fmt::format("{}.condition_{}", condition.formula->where(), condition.number);
  }
  std::size_t k = 0;
  if (i < first_control_switch_.back()) {
    while (first_control_switch_[k + 1] <= i) ++k;
    return d_.controls[k]->name() + "." + d_.controls[k]->switch_name(i - first_control_switch_[k]);
  }
  while (first_switch_[k + 1] <= i) ++k;
  return d_.forces[k]->name() + "." + d_.forces[k]->switch_name(i - first_switch_[k]);
}

std::string Mechanism::name_of_force_state(int i) const {
  std::size_t k = 0;
  while (first_force_state_[k + 1] <= i) ++k;
  const ForceElement& force = *d_.forces[k];
  if (force.n_states() == 1) return force.name();
  return fmt::format("{}.state_{}", force.name(), i - first_force_state_[k] + 1);
}

}  // namespace flexura::mbs
