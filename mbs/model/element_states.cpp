// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>

#include "mbs/model/work.hpp"

/// Dynamic states and switches that belong to single elements.
namespace flexura::mbs {

void Mechanism::take_states(const State& s, Work& work) const {
  work.kin.c = s.c.data();
  // A caller that knows nothing of switches has them all off.
  for (std::size_t i = 0; i < work.switches.size(); ++i) work.switches[i] = i < s.root.size() ? s.root[i] : 0;
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
}

bool Mechanism::on_root(int which, State& s, Scratch& scratch) const {
  Work& work = work_of(scratch);
  forward(Level::velocity, s.t, s.p.data(), s.v.data(), nullptr, work);
  take_states(s, work);
  evaluate_signals(work);
  s.root.resize(first_switch_.back(), 0);
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
  s.root.assign(first_switch_.back(), 0);
  for (std::size_t i = 0; i < d_.controls.size(); ++i)
    if (d_.controls[i]->n_switches() > 0)
      d_.controls[i]->start_switches(work.signals.data(), s.c.data() + first_state_[i]);
  for (std::size_t i = 0; i < d_.forces.size(); ++i) {
    if (d_.forces[i]->n_switches() == 0) continue;
    own_states(i, work);
    d_.forces[i]->start_switches(work.kin, work.signals.data(), s.root.data() + first_switch_[i],
                                 s.c.data() + first_force_state_[i]);
  }
}

std::string Mechanism::name_of_root(int i) const {
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
