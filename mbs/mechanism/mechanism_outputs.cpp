// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/mechanism_outputs.hpp"

#include <vector>

#include "mbs/mechanism/outputs/joint_reaction.hpp"

namespace flexura::mbs {

using Source = ElementStates::SignalSource;

void MechanismOutputs::take_signals(const State& s, MechanismScratch& work) const {
  Eigen::VectorXd& signals = work.signals.values;
  const auto& sources = m_.states.sources();
  signals(0) = s.t;
  for (std::size_t k = 1; k < sources.size(); ++k) {
    const Source& source = sources[k];
    if (source.kind == Source::Kind::coordinate) signals(k) = work.motion.kin.coordinate(source.coordinate);
    if (source.kind == Source::Kind::input)
      signals(k) = m_.states.input_now(source.element, work.motion, work.signals);
    if (source.kind == Source::Kind::speed) signals(k) = work.motion.kin.speed(source.coordinate);
  }
}

void MechanismOutputs::take_controls(bool feed_through, MechanismScratch& work,
                                     std::vector<double>& controlled) const {
  const MechanismDescription& d = m_.tree.d;
  for (std::size_t i = 0; i < d.controls.size(); ++i) {
    if (d.controls[i]->feeds_through() != feed_through) continue;
    controlled[i] = m_.states.control_output(static_cast<int>(i), work.motion, work.signals);
    if (const int k = d.signals.find(d.controls[i]->name()); k >= 0) work.signals.values(k) = controlled[i];
  }
}

std::vector<bool> MechanismOutputs::late_measures() const {
  const MechanismDescription& d = m_.tree.d;
  const auto& sources = m_.states.sources();
  std::vector<bool> is_late(d.measures.size(), false);
  for (std::size_t i = 0; i < d.measures.size(); ++i) {
    is_late[i] = d.measures[i]->exerted().by != Exerted::By::none &&
                 m_.states.coupled_measure(static_cast<int>(i)) < 0;
    for (const int k : d.measures[i]->reads())
      if (sources[k].kind == Source::Kind::measure && is_late[sources[k].element]) is_late[i] = true;
  }
  return is_late;
}

void MechanismOutputs::take_measures(const std::vector<bool>& wanted, bool now, MechanismScratch& work,
                                     std::vector<double>& measured) const {
  const MechanismDescription& d = m_.tree.d;
  for (std::size_t i = 0; i < d.measures.size(); ++i) {
    if (wanted[i] != now) continue;
    const Measure& measure = *d.measures[i];
    if (const int a = m_.states.coupled_measure(static_cast<int>(i)); a >= 0)
      measured[i] = work.signals.algebraic(static_cast<Eigen::Index>(m_.states.algebraic().size()) + a);
    else
      measured[i] = shown_value(m_.tree, m_.rows, m_.states, measure, work.motion, work.wrenches, work.rows,
                                work.signals);
    if (const int k = d.signals.find(measure.name()); k >= 0) work.signals.values(k) = measured[i];
  }
}

void MechanismOutputs::evaluate(const std::vector<int>& which, const State& s, ConstVectorRef v_dot,
                                MechanismScratch& work, VectorRef values) const {
  const MechanismDescription& d = m_.tree.d;
  residual_.move(TreeMotion::Level::acceleration, s, v_dot.data(), work);
  residual_.take_states(s, work);
  m_.dynamics.body_forces(work.motion, work.wrenches);
  m_.dynamics.set_deformations(work.motion, work.wrenches);  // for energies and momenta
  // Measures that only the output asks for may read signals that no force needs: all of them, in their order.
  take_signals(s, work);
  std::vector<double> measured(d.measures.size()), controlled(d.controls.size());
  take_controls(false, work, controlled);
  const std::vector<bool> is_late = late_measures();
  take_measures(is_late, false, work, measured);
  take_controls(true, work, controlled);
  m_.followed.evaluate(TreeMotion::Level::velocity, work.motion, work.signals, work.rows);
  for (Spatial& load : work.wrenches.on_marker) load = {};
  BodyLoads loads(m_.tree, work.motion, work.wrenches, 1.0);
  work.wrenches.on_closure.assign(m_.tree.places.size(), Vector6d::Zero());
  for (std::size_t i = 0; i < d.forces.size(); ++i) {
    m_.states.own_states(i, work.motion, work.signals);
    d.forces[i]->apply(work.motion.kin, work.signals.values.data(), loads);
  }
  work.rows.x.setZero();
  BodyLoads reactions(m_.tree, work.motion, work.wrenches, -1.0);
  m_.rows.add_constraint_loads(s.lambda.data(), Which::all, work.motion, work.rows, reactions);
  m_.dynamics.backward(work.motion, work.wrenches, work.wrenches.r.data());
  const EnergyReport energies = residual_.energies(s.lambda.data(), work);

  if (m_.tree.n_dyn > m_.tree.n_own) {
    // What is measured on a body shows its deformation where the forces above did not see it, too.
    const std::vector<MarkerState> rigid = work.motion.kin.markers;
    m_.kinematics.show_following(work.motion);
    take_measures(is_late, false, work, measured);
    work.motion.kin.markers = rigid;
  }
  take_measures(is_late, true, work, measured);
  quantities_.evaluate(
      which,
      {work.motion, work.wrenches, work.rows, work.signals, measured, controlled, energies,
       [&](int body) { return m_.coordinates.modal_coordinates(body, s); },
       [&](int input) { return m_.states.input_now(input, work.motion, work.signals); },
       [&](int force) { m_.states.own_states(static_cast<std::size_t>(force), work.motion, work.signals); },
       [&] { return m_.dynamics.total_momentum(work.motion, work.wrenches); }},
      values);
}

}  // namespace flexura::mbs
