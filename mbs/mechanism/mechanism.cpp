// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/mechanism.hpp"

#include <utility>

#include "mbs/mechanism/joined.hpp"
#include "mbs/mechanism/motion/turning_axes.hpp"
#include "mbs/mechanism/without_loads.hpp"

namespace flexura::mbs {

using Level = TreeMotion::Level;

Mechanism::Mechanism(MechanismDescription description)
    : m_(std::make_unique<Joined>(std::move(description))) {
  // A large mechanism asks for the dense factors, which find the name, only where something is wrong.
  const auto scratch = make_scratch();
  if (m_->tree.n_v > 300 && factor_mass(m_->start.p, *scratch)) return;
  Eigen::MatrixXd M(m_->tree.n_v, m_->tree.n_v);
  mass_matrix(m_->start.p, *scratch, M);
  m_->mass.check(M, m_->coordinates);
}

Mechanism::~Mechanism() = default;

// ---- what it is

const MechanismDescription& Mechanism::description() const {
  return m_->tree.d;
}

Sizes Mechanism::sizes() const {
  Sizes sizes;
  sizes.n_p = m_->tree.n_p;
  sizes.n_v = m_->tree.n_v;
  sizes.n_flx = m_->tree.n_flx;
  sizes.n_dyn = m_->tree.n_dyn;
  for (int i = 0; i < sizes.n_dyn; ++i) sizes.n_held += is_held(i);
  sizes.n_lambda = static_cast<int>(m_->rows.kept().size());
  sizes.n_root = m_->states.n_switches();
  sizes.n_alg = m_->n_algebraic();
  return sizes;
}

std::unique_ptr<Equations::Scratch> Mechanism::make_scratch() const {
  return std::make_unique<MechanismScratch>(*m_);
}

MechanismScratch& Mechanism::scratch_of(Scratch& scratch) const {
  return static_cast<MechanismScratch&>(scratch);
}

MechanismScratch& Mechanism::move(double t, ConstVectorRef p, Scratch& scratch) const {
  MechanismScratch& work = scratch_of(scratch);
  m_->kinematics.forward(Level::position, t, p.data(), nullptr, nullptr, work.motion);
  return work;
}

MechanismScratch& Mechanism::observe(const State& s, Scratch& scratch) const {
  MechanismScratch& work = scratch_of(scratch);
  m_->residual.move_and_observe(s, work);
  return work;
}

State Mechanism::initial_state(double t) const {
  State s;
  s.t = t;
  s.p = m_->start.p;
  s.v = m_->start.v;
  if (t != 0.0) m_->start.drive_at(t, s.p, s.v);
  m_->states.start(s, static_cast<int>(m_->rows.contacts().size()));
  s.lambda = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(m_->rows.kept().size()));
  if (m_->followed.any()) {
    const auto scratch = make_scratch();
    m_->constraints.start_followed(s, m_->start.given_v, scratch_of(*scratch));
  }
  if (!m_->rows.contacts().empty()) start_contacts(s, *make_scratch());
  return s;
}

const std::vector<bool>& Mechanism::given_positions() const {
  return m_->start.given_p;
}
const std::vector<bool>& Mechanism::given_velocities() const {
  return m_->start.given_v;
}
bool Mechanism::in_tree(int joint) const {
  return m_->tree.places[joint].in_tree();
}
bool Mechanism::is_reversed(int joint) const {
  return m_->tree.is_reversed(joint);
}
const std::vector<JointPlace>& Mechanism::joint_places() const {
  return m_->tree.places;
}
const FlexibleBody* Mechanism::deforming(int body) const {
  return m_->tree.flexible(body);
}
int Mechanism::modal_position(int body) const {
  const TreeBody& b = m_->tree.bodies[body];
  return b.m > 0 ? b.i_p : -1;
}
const double* Mechanism::modal_coordinates(int body, const State& s) const {
  return m_->coordinates.modal_coordinates(body, s);
}

// ---- coordinates

void Mechanism::kinematic(ConstVectorRef p, ConstVectorRef w, VectorRef p_dot) const {
  m_->coordinates.kinematic(p, w, p_dot);
}
void Mechanism::retract(ConstVectorRef p, ConstVectorRef d, VectorRef p_out) const {
  m_->coordinates.retract(p, d, p_out);
}
bool Mechanism::elastic_coordinate(int i_v, int& i_p, double& k, double& d) const {
  return m_->coordinates.elastic_coordinate(i_v, i_p, k, d);
}
void Mechanism::add_elastic_tangents(const State& s, MatrixRef r_p, MatrixRef r_v) const {
  m_->coordinates.add_elastic_tangents(s, r_p, r_v);
}
double Mechanism::position_scale(int i) const {
  return m_->coordinates.position_scale(i);
}
double Mechanism::velocity_scale(int i) const {
  return m_->coordinates.velocity_scale(i);
}
double Mechanism::rate_scale(int i) const {
  return m_->coordinates.rate_scale(i);
}
std::string Mechanism::name_of_position(int i) const {
  return m_->coordinates.name_of_position(i);
}
std::string Mechanism::name_of_velocity(int i) const {
  return m_->coordinates.name_of_velocity(i);
}
bool Mechanism::is_held(int i) const {
  return i < m_->tree.n_own && m_->states.is_held(i);
}
std::string Mechanism::name_of_dynamic(int i) const {
  return i < m_->tree.n_own ? m_->states.name_of_state(i) : m_->coordinates.name_of_following(i);
}

// ---- equations of motion

void Mechanism::momentum(const State& s, ConstVectorRef v_dot, Scratch& scratch, VectorRef r,
                         VectorRef c_rate, VectorRef b) const {
  m_->residual.momentum(s, v_dot, scratch_of(scratch), r, c_rate, b);
}

void Mechanism::residuals(const State& s, ConstVectorRef v_dot, ConstVectorRef mu, Scratch& scratch,
                          VectorRef r, VectorRef c_rate, VectorRef b, VectorRef g_dot, VectorRef g,
                          VectorRef GT_mu) const {
  m_->residual.residuals(s, v_dot, mu, scratch_of(scratch), r, c_rate, b, g_dot, g, GT_mu);
}

bool Mechanism::tangents(const State& s, ConstVectorRef v_dot, TangentScope scope, Scratch& scratch,
                         TangentMatrices& out) const {
  m_->tangents.evaluate(s, v_dot, scope, scratch_of(scratch), out);
  return true;
}

void Mechanism::mass_matrix(ConstVectorRef p, Scratch& scratch, MatrixRef M) const {
  MechanismScratch& work = move(0.0, p, scratch);
  m_->dynamics.set_deformations(work.motion, work.wrenches);
  m_->mass.own_inertia(work.motion, work.wrenches, work.inertias);
  m_->mass.fill(work.motion, work.inertias, M);
}

bool Mechanism::factor_mass(ConstVectorRef p, Scratch& scratch) const {
  MechanismScratch& work = move(0.0, p, scratch);
  m_->dynamics.set_deformations(work.motion, work.wrenches);
  m_->mass.own_inertia(work.motion, work.wrenches, work.inertias);
  return m_->mass.factor(work.motion, work.inertias);
}

void Mechanism::solve_mass(Scratch& scratch, VectorRef x) const {
  m_->mass.solve(scratch_of(scratch).inertias, x);
}

EnergyReport Mechanism::energy(const State& s, ConstVectorRef, Scratch& scratch) const {
  MechanismScratch& work = observe(s, scratch);
  m_->dynamics.set_deformations(work.motion, work.wrenches);
  return m_->residual.energies(s.lambda.data(), work);
}

// ---- constraints

void Mechanism::position_constraints(When when, ConstVectorRef p, Scratch& scratch, VectorRef g) const {
  m_->constraints.position(when, p, scratch_of(scratch), g);
}
void Mechanism::velocity_constraints(When when, ConstVectorRef p, ConstVectorRef v, Scratch& scratch,
                                     VectorRef g_dot) const {
  m_->constraints.velocity(when, p, v, scratch_of(scratch), g_dot);
}
void Mechanism::constraints(When when, ConstVectorRef p, ConstVectorRef v, Scratch& scratch, VectorRef g,
                            VectorRef g_dot) const {
  m_->constraints.both(when, p, v, scratch_of(scratch), g, g_dot);
}
void Mechanism::acceleration_constraints(When when, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                         Scratch& scratch, VectorRef g_ddot) const {
  m_->constraints.acceleration(when, p, v, v_dot, scratch_of(scratch), g_ddot);
}
void Mechanism::apply_GT(When when, ConstVectorRef p, ConstVectorRef x, Scratch& scratch,
                         VectorRef f_c) const {
  m_->constraints.apply_GT(when, p, x, scratch_of(scratch), f_c);
}
void Mechanism::constraint_matrix(When when, ConstVectorRef p, Scratch& scratch, MatrixRef G) const {
  m_->constraints.matrix(when, p, scratch_of(scratch), G);
}
ConstraintSizes Mechanism::constraint_sizes(When when, ConstVectorRef p, Scratch& scratch) const {
  return m_->constraints.sizes(m_->rows.kept(), when, p, scratch_of(scratch));
}
ConstraintSizes Mechanism::left_out_sizes(When when, ConstVectorRef p, Scratch& scratch) const {
  return m_->constraints.sizes(m_->rows.left_out(), when, p, scratch_of(scratch));
}
bool Mechanism::algebraic_is_coupled() const {
  return !m_->states.coupled_measures().empty();
}
bool Mechanism::follows_states() const {
  return m_->followed.any();
}
void Mechanism::left_out_constraints(When when, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                     Scratch& scratch, VectorRef g, VectorRef g_dot, VectorRef g_ddot) const {
  m_->constraints.left_out(when, p, v, v_dot, scratch_of(scratch), g, g_dot, g_ddot);
}
void Mechanism::start_contacts(State& s, Scratch& scratch) const {
  const MechanismScratch& work = move(s.t, s.p, scratch);
  m_->rows.start_contacts(work.motion, m_->states.n_algebraic(), s);
}

// ---- elements

void Mechanism::roots(const State& s, Scratch& scratch, VectorRef values) const {
  MechanismScratch& work = observe(s, scratch);
  m_->states.roots(work.motion, work.signals, values);
  if (s.hysteresis.size() == values.size()) values += s.hysteresis;
}

bool Mechanism::on_root(int which, State& s, Scratch& scratch) const {
  MechanismScratch& work = observe(s, scratch);
  m_->states.change_switch(which, s, work.motion, work.signals);
  return false;
}

void Mechanism::start_switches(State& s, Scratch& scratch) const {
  m_->states.start_switches(s, [&]() -> std::pair<Motion&, const Signals&> {
    MechanismScratch& work = observe(s, scratch);
    return {work.motion, work.signals};
  });
  hold_conditions(s, scratch);
}

void Mechanism::hold_conditions(State& s, Scratch& scratch) const {
  if (!m_->states.has_conditions()) return;
  m_->states.release_conditions(s);
  m_->states.hold_conditions(s, observe(s, scratch).signals);
}

bool Mechanism::is_condition(int root) const {
  return m_->states.is_condition(root);
}
bool Mechanism::is_kink(int root) const {
  return m_->states.is_kink(root);
}
bool Mechanism::jumps_at(int root) const {
  return m_->states.jumps_at(root);
}
std::string Mechanism::name_of_root(int i) const {
  return m_->states.name_of_root(i);
}
std::string Mechanism::describe_root(int i) const {
  return is_condition(i) ? m_->states.describe_root(i) : Equations::describe_root(i);
}
std::string Mechanism::name_of_algebraic(int i) const {
  const std::vector<int>& controls = m_->states.algebraic();
  const int n = static_cast<int>(controls.size()), n_before = m_->states.n_algebraic();
  if (i < n) return description().controls[controls[i]]->name();
  if (i < n_before) return description().measures[m_->states.coupled_measures()[i - n]]->name();
  return m_->rows.constraints()[m_->rows.contacts()[i - n_before]]->name() + ".contact";
}
std::vector<std::shared_ptr<const TimeFunction>> Mechanism::functions_of_time() const {
  return m_->states.functions_of_time();
}
std::vector<std::shared_ptr<const MotionFunction>> Mechanism::functions_of_motion() const {
  return m_->states.functions_of_motion();
}
void Mechanism::arguments_of_motion(const State& s, Scratch& scratch, Eigen::VectorXd& x) const {
  MechanismScratch& work = observe(s, scratch);
  m_->states.arguments_of_motion(work.motion, work.signals, x);
}
int Mechanism::n_inputs() const {
  return static_cast<int>(description().inputs.size());
}
std::string Mechanism::name_of_input(int i) const {
  return description().inputs[i].name;
}
double Mechanism::input_value(int i, double t) const {
  return description().inputs[i].value->evaluate(&t);
}

// ---- what it shows

std::vector<OutputInfo> Mechanism::quantities() const {
  return m_->outputs.quantities().infos();
}
std::vector<int> Mechanism::usual_quantities() const {
  return m_->outputs.quantities().usual();
}
std::vector<bool> Mechanism::not_unique(When when, ConstVectorRef p) const {
  const auto scratch = make_scratch();
  MechanismScratch& work = scratch_of(*scratch);
  m_->constraints.move(when, p, work);
  return m_->outputs.quantities().not_unique(m_->dynamics, work.motion, work.wrenches, work.rows);
}
void Mechanism::evaluate(const std::vector<int>& which, const State& s, ConstVectorRef v_dot,
                         Scratch& scratch, VectorRef values) const {
  m_->outputs.evaluate(which, s, v_dot, scratch_of(scratch), values);
}
Unloaded Mechanism::without_loads(const State& s, Scratch& scratch) const {
  return mbs::without_loads(*m_, m_->residual, s, scratch_of(scratch));
}
std::vector<double> Mechanism::sizes_of_forces(const State& s, Scratch& scratch) const {
  return mbs::sizes_of_forces(*m_, m_->residual, s, scratch_of(scratch));
}

void Mechanism::body_poses(const State& s, Scratch& scratch, std::vector<Pose>& poses) const {
  const MechanismScratch& work = move(s.t, s.p, scratch);
  poses.resize(description().bodies.size());
  for (std::size_t b = 0; b < poses.size(); ++b) poses[b] = work.motion.bodies[b].X_WB;
}
Eigen::VectorXd Mechanism::force_along(CoordinateRef c, const State& s, Scratch& scratch) const {
  MechanismScratch& work = move(s.t, s.p, scratch);
  m_->dynamics.clear_loads(work.wrenches);
  BodyLoads(m_->tree, work.motion, work.wrenches, -1.0).apply(c, 1.0);
  m_->dynamics.backward(work.motion, work.wrenches, work.wrenches.r.data());
  return work.wrenches.r.head(m_->tree.n_v);
}

void Mechanism::body_motions(const State& s, ConstVectorRef v_dot, Scratch& scratch,
                             std::vector<MarkerState>& bodies) const {
  MechanismScratch& work = scratch_of(scratch);
  m_->residual.move(Level::acceleration, s, v_dot.data(), work);
  bodies.resize(description().bodies.size());
  for (std::size_t b = 0; b < bodies.size(); ++b)
    bodies[b] = {work.motion.bodies[b].X_WB, work.motion.bodies[b].V, work.motion.bodies[b].A};
}

Eigen::MatrixXd Mechanism::turning_axes(const State& s, const Vector3d& Omega_W, Scratch& scratch) const {
  MechanismScratch& work = scratch_of(scratch);
  m_->residual.move(Level::velocity, s, nullptr, work);
  return mbs::turning_axes(m_->tree, s, Omega_W, work.motion);
}
Eigen::MatrixXd Mechanism::turning_with_bodies(const State& s, Scratch& scratch) const {
  MechanismScratch& work = scratch_of(scratch);
  m_->residual.move(Level::velocity, s, nullptr, work);
  return mbs::turning_with_bodies(m_->tree, s, work.motion);
}

}  // namespace flexura::mbs
