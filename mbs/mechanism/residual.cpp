// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/residual.hpp"

#include "mbs/mechanism/outputs/joint_reaction.hpp"

namespace flexura::mbs {

void Residual::move(Level level, const State& s, const double* v_dot, MechanismScratch& work) const {
  m_.kinematics.forward(level, s.t, s.p.data(), level == Level::position ? nullptr : s.v.data(), v_dot,
                        work.motion);
}

void Residual::take_states(const State& s, MechanismScratch& work) const {
  m_.states.take_states(s, work.motion, work.signals);
  if (s.a.size() == work.signals.algebraic.size())
    m_.rows.take_contacts(s.a, m_.states.n_algebraic(), work.rows);
}

void Residual::observe(const State& s, MechanismScratch& work) const {
  take_states(s, work);
  m_.states.evaluate_signals(work.motion, work.signals);
  m_.followed.evaluate(Level::velocity, work.motion, work.signals, work.rows);
}

// After move() on acceleration level: what moves the bodies less what acts on them.
void Residual::finish(const State& s, MechanismScratch& work, VectorRef r, VectorRef c_rate,
                      VectorRef b) const {
  take_states(s, work);
  m_.dynamics.body_forces(work.motion, work.wrenches);
  m_.states.evaluate_signals(work.motion, work.signals);
  m_.followed.evaluate(Level::velocity, work.motion, work.signals, work.rows);
  const std::vector<int>& coupled = m_.states.coupled_measures();
  if (!coupled.empty()) work.wrenches.on_closure.assign(m_.tree.places.size(), Vector6d::Zero());
  element_loads(s, Which::all, c_rate, b, work);
  m_.dynamics.backward(work.motion, work.wrenches, r.data());
  coupled_equations(work, b);
  m_.dynamics.following_rates(work.motion, work.wrenches, c_rate.data());
}

// Of measures of accelerations and reactions: what they are taken for less what they are.
void Residual::coupled_equations(MechanismScratch& work, VectorRef b) const {
  auto i = static_cast<Eigen::Index>(m_.states.algebraic().size());
  for (const int which : m_.states.coupled_measures()) {
    const Measure& measure = *m_.tree.d.measures[static_cast<std::size_t>(which)];
    b(i) = work.signals.algebraic(i) - shown_value(m_.tree, m_.rows, m_.states, measure, work.motion,
                                                   work.wrenches, work.rows, work.signals);
    ++i;
  }
}

void Residual::momentum(const State& s, ConstVectorRef v_dot, MechanismScratch& work, VectorRef r,
                        VectorRef c_rate, VectorRef b) const {
  move(Level::acceleration, s, v_dot.data(), work);
  finish(s, work, r, c_rate, b);
}

void Residual::residuals(const State& s, ConstVectorRef v_dot, ConstVectorRef mu, MechanismScratch& work,
                         VectorRef r, VectorRef c_rate, VectorRef b, VectorRef g_dot, VectorRef g,
                         VectorRef GT_mu) const {
  move(Level::acceleration, s, v_dot.data(), work);
  if (mu.size() > 0) {
    if (m_.followed.any()) observe(s, work);
    m_.rows.position(work.motion, work.rows, g);
    m_.rows.velocity(work.motion, work.rows, g_dot);
    m_.dynamics.clear_loads(work.wrenches);
    BodyLoads loads(m_.tree, work.motion, work.wrenches, -1.0);
    m_.rows.add_constraint_loads(mu.data(), Which::all, work.motion, work.rows, loads);
    m_.dynamics.backward(work.motion, work.wrenches, GT_mu.data());
  }
  finish(s, work, r, c_rate, b);
}

void Residual::element_loads(const State& s, Which which, VectorRef c_rate, VectorRef b,
                             MechanismScratch& work) const {
  const MechanismDescription& d = m_.tree.d;
  const double* const signals = work.signals.values.data();
  const bool all = which == Which::all;
  if (all)
    for (std::size_t i = 0; i < d.controls.size(); ++i) {
      const int first = m_.states.first_state_of_control(i);
      d.controls[i]->rates(signals, work.motion.kin.c + first, c_rate.data() + first);
    }
  BodyLoads loads(m_.tree, work.motion, work.wrenches, 1.0);
  for (std::size_t i = 0; i < d.forces.size(); ++i) {
    if (!all && d.forces[i]->has_derivatives() != (which == Which::with_derivatives)) continue;
    m_.states.own_states(i, work.motion, work.signals);
    d.forces[i]->apply(work.motion.kin, signals, loads);
    if (d.forces[i]->n_states() > 0)
      d.forces[i]->rates(work.motion.kin, signals, c_rate.data() + m_.states.first_state_of_force(i));
  }
  if (all) {
    m_.states.algebraic_equations(work.signals, b);
    m_.rows.contact_equations(work.signals.algebraic, m_.states.n_algebraic(), work.motion, b);
  }
  BodyLoads reactions(m_.tree, work.motion, work.wrenches, -1.0);
  m_.rows.add_constraint_loads(s.lambda.data(), which, work.motion, work.rows, reactions);
}

EnergyReport Residual::energies(const double* lambda, MechanismScratch& work) const {
  EnergyReport report;
  m_.dynamics.add_energies(work.motion, work.wrenches, report);
  Powers powers;
  for (std::size_t i = 0; i < m_.tree.d.forces.size(); ++i) {
    m_.states.own_states(i, work.motion, work.signals);
    m_.tree.d.forces[i]->add_powers(work.motion.kin, work.signals.values.data(), powers);
  }
  report.potential += powers.potential;
  report.input_power += powers.input;
  report.dissipated_power += powers.dissipated;
  report.input_power += m_.rows.power(lambda, work.motion, work.rows);
  return report;
}

}  // namespace flexura::mbs
