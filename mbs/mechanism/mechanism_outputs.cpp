// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/measures/shown_measure.hpp"
#include "mbs/mechanism/joined.hpp"

/// What a mechanism shows of one state: quantities, poses and motions of bodies.
namespace flexura::mbs {
namespace {

// The joint whose reaction a measure takes; -1: none.
int joint_read_by(const Measure& measure) {
  const auto* shown = dynamic_cast<const ShownMeasure*>(&measure);
  return shown ? shown->joint() : -1;
}

}  // namespace

std::vector<OutputInfo> Mechanism::quantities() const {
  return m_->quantities.infos();
}
std::vector<int> Mechanism::usual_quantities() const {
  return m_->quantities.usual();
}

std::vector<bool> Mechanism::not_unique(double t, ConstVectorRef p) const {
  const auto scratch = make_scratch();
  MechanismScratch& work = move(t, p, *scratch);
  return m_->quantities.not_unique(m_->dynamics, work.motion, work.wrenches, work.rows);
}

void Mechanism::evaluate(const std::vector<int>& which, const State& s, ConstVectorRef v_dot,
                         Scratch& scratch, VectorRef values) const {
  const MechanismDescription& d = description();
  MechanismScratch& work = scratch_of(scratch);
  m_->residual.move(TreeMotion::Level::acceleration, s, v_dot.data(), work);
  m_->residual.take_states(s, work);
  m_->dynamics.body_forces(work.motion, work.wrenches);
  Eigen::VectorXd& signals = work.signals.values;
  const auto& sources = m_->states.sources();
  // Measures that only the output asks for may read signals that no force needs: all of them, in their order.
  signals(0) = s.t;
  std::vector<double> measured(d.measures.size()), controlled(d.controls.size());
  for (std::size_t k = 1; k < sources.size(); ++k) {
    const ElementStates::SignalSource& source = sources[k];
    if (source.kind == ElementStates::SignalSource::Kind::coordinate)
      signals(k) = work.motion.kin.coordinate(source.coordinate);
    if (source.kind == ElementStates::SignalSource::Kind::input)
      signals(k) = m_->states.input_now(source.element, work.motion, work.signals);
    if (source.kind == ElementStates::SignalSource::Kind::speed)
      signals(k) = work.motion.kin.speed(source.coordinate);
  }
  const auto evaluate_controls = [&](bool feed_through) {
    for (std::size_t i = 0; i < d.controls.size(); ++i) {
      if (d.controls[i]->feeds_through() != feed_through) continue;
      controlled[i] = m_->states.control_output(static_cast<int>(i), work.motion, work.signals);
      if (const int k = d.signals.find(d.controls[i]->name()); k >= 0) signals(k) = controlled[i];
    }
  };
  evaluate_controls(false);
  // Measures of reactions, and formulas that read them, come last.
  std::vector<bool> is_late(d.measures.size(), false);
  for (std::size_t i = 0; i < d.measures.size(); ++i) {
    is_late[i] = joint_read_by(*d.measures[i]) >= 0;
    for (const int k : d.measures[i]->reads())
      if (sources[k].kind == ElementStates::SignalSource::Kind::measure && is_late[sources[k].element])
        is_late[i] = true;
  }
  const auto measure = [&](bool late) {
    for (std::size_t i = 0; i < d.measures.size(); ++i) {
      if (is_late[i] != late) continue;
      const int joint = joint_read_by(*d.measures[i]);
      measured[i] =
          joint < 0 ? d.measures[i]->value(work.motion.kin, signals.data())
                    : static_cast<const ShownMeasure&>(*d.measures[i])
                          .value_of_load(work.motion.kin, m_->quantities.joint_reaction(
                                                              joint, work.motion, work.wrenches, work.rows));
      if (const int k = d.signals.find(d.measures[i]->name()); k >= 0) signals(k) = measured[i];
    }
  };
  measure(false);
  evaluate_controls(true);
  BodyLoads loads(m_->tree, work.motion, work.wrenches, 1.0);
  work.wrenches.on_closure.assign(m_->tree.places.size(), Vector6d::Zero());
  for (std::size_t i = 0; i < d.forces.size(); ++i) {
    m_->states.own_states(i, work.motion, work.signals);
    d.forces[i]->apply(work.motion.kin, signals.data(), loads);
  }
  work.rows.x.setZero();
  BodyLoads reactions(m_->tree, work.motion, work.wrenches, -1.0);
  m_->rows.add_constraint_loads(s.lambda.data(), Which::all, work.motion, work.rows, reactions);
  m_->dynamics.backward(work.motion, work.wrenches, work.wrenches.r.data());
  const EnergyReport energies = m_->residual.energies(s.lambda.data(), work);

  if (m_->tree.n_dyn > m_->tree.n_own) {
    // What is measured on a body shows its deformation where the forces above did not see it, too.
    const std::vector<MarkerState> rigid = work.motion.kin.markers;
    m_->kinematics.show_following(work.motion);
    measure(false);
    work.motion.kin.markers = rigid;
  }
  measure(true);
  m_->quantities.evaluate(
      which,
      {work.motion, work.wrenches, work.rows, work.signals, measured, controlled, energies,
       [&](int body) { return modal_coordinates(body, s); },
       [&](int input) { return m_->states.input_now(input, work.motion, work.signals); },
       [&](int force) { m_->states.own_states(static_cast<std::size_t>(force), work.motion, work.signals); },
       [&] { return m_->dynamics.total_momentum(work.motion, work.wrenches); }},
      values);
}

void Mechanism::body_poses(const State& s, Scratch& scratch, std::vector<Pose>& poses) const {
  const MechanismScratch& work = move(s.t, s.p, scratch);
  poses.resize(description().bodies.size());
  for (std::size_t b = 0; b < poses.size(); ++b) poses[b] = work.motion.bodies[b].X_WB;
}

void Mechanism::body_motions(const State& s, ConstVectorRef v_dot, Scratch& scratch,
                             std::vector<MarkerState>& bodies) const {
  MechanismScratch& work = scratch_of(scratch);
  m_->residual.move(TreeMotion::Level::acceleration, s, v_dot.data(), work);
  bodies.resize(description().bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b)
    bodies[b] = {work.motion.bodies[b].X_WB, work.motion.bodies[b].V, work.motion.bodies[b].A};
}

}  // namespace flexura::mbs
