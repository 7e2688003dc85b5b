// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/mechanism/work.hpp"

/// Mechanism as the solvers see it.
namespace flexura::mbs {

Sizes Mechanism::sizes() const {
  Sizes sizes;
  sizes.n_p = n_p_;
  sizes.n_v = n_v_;
  sizes.n_flx = n_flx_;
  sizes.n_dyn = n_dyn_;
  sizes.n_lambda = static_cast<int>(kept_rows_.size());
  sizes.n_root = n_switches();
  sizes.n_alg = static_cast<int>(algebraic_.size() + contacts_.size());
  return sizes;
}

State Mechanism::initial_state() const {
  State s;
  s.p = p_0_;
  s.v = v_0_;
  s.c.setZero(n_dyn_);
  for (std::size_t i = 0; i < d_.controls.size(); ++i) d_.controls[i]->start(s.c.data() + first_state_[i]);
  for (std::size_t i = 0; i < d_.forces.size(); ++i) d_.forces[i]->start(s.c.data() + first_force_state_[i]);
  s.lambda = Eigen::VectorXd::Zero(kept_rows_.size());
  s.a.resize(sizes().n_alg);
  for (std::size_t k = 0; k < algebraic_.size(); ++k)
    s.a(static_cast<Eigen::Index>(k)) = d_.controls[algebraic_[k]]->start_algebraic();
  s.root.assign(n_switches(), 0);
  if (!contacts_.empty()) start_contacts(s, *make_scratch());
  return s;
}

void Mechanism::kinematic(ConstVectorRef p, ConstVectorRef w, VectorRef p_dot) const {
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    const JointPlace& place = places_[body.joint];
    place.joint->kinematic(p.data() + place.i_p, w.data() + place.i_v, p_dot.data() + place.i_p);
    p_dot.segment(body.i_p, body.m) = w.segment(body.i_v, body.m);
  }
}

void Mechanism::retract(ConstVectorRef p, ConstVectorRef d, VectorRef p_out) const {
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    const JointPlace& place = places_[body.joint];
    place.joint->retract(p.data() + place.i_p, d.data() + place.i_v, p_out.data() + place.i_p);
    p_out.segment(body.i_p, body.m) = p.segment(body.i_p, body.m) + d.segment(body.i_v, body.m);
  }
}

// After forward() on acceleration level: what moves the bodies less what acts on them.
void Mechanism::applied_forces(const State& s, VectorRef c_rate, VectorRef b, Work& work) const {
  take_states(s, work);
  body_forces(true, work);
  evaluate_signals(work);
  element_loads(s, Which::all, c_rate, b, work);
}

// What forces, controls and constraints contribute, after take_states() and evaluate_signals().
void Mechanism::element_loads(const State& s, Which which, VectorRef c_rate, VectorRef b, Work& work) const {
  const bool all = which == Which::all;
  if (all)
    for (std::size_t i = 0; i < d_.controls.size(); ++i)
      d_.controls[i]->rates(work.signals.data(), work.kin.c + first_state_[i],
                            c_rate.data() + first_state_[i]);
  BodyLoads loads(*this, work, 1.0);
  for (std::size_t i = 0; i < d_.forces.size(); ++i) {
    if (!all && d_.forces[i]->has_derivatives() != (which == Which::with_derivatives)) continue;
    own_states(i, work);
    d_.forces[i]->apply(work.kin, work.signals.data(), loads);
    if (d_.forces[i]->n_states() > 0)
      d_.forces[i]->rates(work.kin, work.signals.data(), c_rate.data() + first_force_state_[i]);
  }
  if (all) algebraic_equations(work, b);
  add_constraint_loads(s.lambda.data(), -1.0, work, which);
}

void Mechanism::momentum(const State& s, ConstVectorRef v_dot, Scratch& scratch, VectorRef r,
                         VectorRef c_rate, VectorRef b) const {
  Work& work = work_of(scratch);
  forward(Level::acceleration, s.t, s.p.data(), s.v.data(), v_dot.data(), work);
  applied_forces(s, c_rate, b, work);
  backward(work, r.data());
  following_rates(work, c_rate.data());
}

void Mechanism::constraint_rows(VectorRef g, VectorRef g_dot, Work& work) const {
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    own_contact(k, work);
    constraints_[k]->position(work.kin, work.rows_g.data() + first_row_[k]);
  }
  for (std::size_t i = 0; i < kept_rows_.size(); ++i) g(i) = work.rows_g(kept_rows_[i]);
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    own_contact(k, work);
    constraints_[k]->velocity(work.kin, work.rows_g.data() + first_row_[k]);
  }
  for (std::size_t i = 0; i < kept_rows_.size(); ++i) g_dot(i) = work.rows_g(kept_rows_[i]);
}

void Mechanism::constraints(double t, ConstVectorRef p, ConstVectorRef v, Scratch& scratch, VectorRef g,
                            VectorRef g_dot) const {
  Work& work = work_of(scratch);
  forward(Level::velocity, t, p.data(), v.data(), nullptr, work);
  constraint_rows(g, g_dot, work);
}

void Mechanism::residuals(const State& s, ConstVectorRef v_dot, ConstVectorRef mu, Scratch& scratch,
                          VectorRef r, VectorRef c_rate, VectorRef b, VectorRef g_dot, VectorRef g,
                          VectorRef GT_mu) const {
  Work& work = work_of(scratch);
  forward(Level::acceleration, s.t, s.p.data(), s.v.data(), v_dot.data(), work);
  if (mu.size() > 0) {
    constraint_rows(g, g_dot, work);
    clear_loads(work);
    add_constraint_loads(mu.data(), -1.0, work);
    backward(work, GT_mu.data());
  }
  applied_forces(s, c_rate, b, work);
  backward(work, r.data());
  following_rates(work, c_rate.data());
}

bool Mechanism::elastic_coordinate(int i_v, int& i_p, double& k, double& d) const {
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    if (i_v < body.i_v || i_v >= body.i_v + body.m) continue;
    const FlexibleBody::Spring own = d_.bodies[b].flexible->spring(i_v - body.i_v);
    i_p = body.i_p + i_v - body.i_v;
    k = own.stiffness;
    d = own.damping;
    return true;
  }
  return false;
}

void Mechanism::add_elastic_tangents(const State& s, MatrixRef r_p, MatrixRef r_v) const {
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    if (body.m == 0) continue;
    d_.bodies[b].flexible->add_tangents(s.p.data() + body.i_p, s.v.data() + body.i_v,
                                        r_p.block(body.i_v, body.i_p, body.m, body.m),
                                        r_v.block(body.i_v, body.i_v, body.m, body.m));
  }
}

void Mechanism::position_constraints(double t, ConstVectorRef p, Scratch& scratch, VectorRef g) const {
  Work& work = work_of(scratch);
  forward(Level::position, t, p.data(), nullptr, nullptr, work);
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    own_contact(k, work);
    constraints_[k]->position(work.kin, work.rows_g.data() + first_row_[k]);
  }
  for (std::size_t i = 0; i < kept_rows_.size(); ++i) g(i) = work.rows_g(kept_rows_[i]);
}

void Mechanism::velocity_constraints(double t, ConstVectorRef p, ConstVectorRef v, Scratch& scratch,
                                     VectorRef g_dot) const {
  Work& work = work_of(scratch);
  forward(Level::velocity, t, p.data(), v.data(), nullptr, work);
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    own_contact(k, work);
    constraints_[k]->velocity(work.kin, work.rows_g.data() + first_row_[k]);
  }
  for (std::size_t i = 0; i < kept_rows_.size(); ++i) g_dot(i) = work.rows_g(kept_rows_[i]);
}

void Mechanism::acceleration_constraints(double t, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                         Scratch& scratch, VectorRef g_ddot) const {
  Work& work = work_of(scratch);
  forward(Level::acceleration, t, p.data(), v.data(), v_dot.data(), work);
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    own_contact(k, work);
    constraints_[k]->acceleration(work.kin, work.rows_g.data() + first_row_[k]);
  }
  for (std::size_t i = 0; i < kept_rows_.size(); ++i) g_ddot(i) = work.rows_g(kept_rows_[i]);
}

void Mechanism::apply_GT(double t, ConstVectorRef p, ConstVectorRef x, Scratch& scratch,
                         VectorRef f_c) const {
  Work& work = work_of(scratch);
  forward(Level::position, t, p.data(), nullptr, nullptr, work);
  clear_loads(work);
  add_constraint_loads(x.data(), -1.0, work);
  backward(work, f_c.data());
}

void Mechanism::constraint_matrix(double t, ConstVectorRef p, Scratch& scratch, MatrixRef G) const {
  Work& work = work_of(scratch);
  forward(Level::position, t, p.data(), nullptr, nullptr, work);
  BodyLoads loads(*this, work, -1.0);
  std::size_t i = 0;
  // Row by row: the loads of a unit multiplier, taken inwards.
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    own_contact(k, work);
    for (; i < kept_rows_.size() && kept_rows_[i] < first_row_[k + 1]; ++i) {
      clear_loads(work);
      work.rows_x.segment(first_row_[k], constraints_[k]->n_rows()).setZero();
      work.rows_x(kept_rows_[i]) = 1.0;
      constraints_[k]->apply_GT(work.kin, work.rows_x.data() + first_row_[k], loads);
      backward(work, work.r.data());
      G.row(i) = work.r.head(n_v_).transpose();
    }
  }
}

EnergyReport Mechanism::energies(const double* lambda, Work& work) const {
  EnergyReport report;
  for (int b : order_) {
    const BodyDescription& description = d_.bodies[b];
    const Work::Body& body = work.bodies[b];
    const Spatial V = body.X_WB.R.transpose() * body.V;
    double mass;
    Vector3d first_moment;
    if (const TreeBody& t = bodies_[b]; t.m > 0) {
      const FlexibleBody& flexible = *description.flexible;
      mass = flexible.mass();
      first_moment = body.flexible->d;
      report.kinetic += flexible.kinetic_energy(work.kin.v + t.i_v, V, *body.flexible);
      report.strain += flexible.strain_energy(work.kin.p + t.i_p);
      report.dissipated_power += flexible.dissipated_power(work.kin.p + t.i_p, work.kin.v + t.i_v);
    } else {
      const RigidInertia& I = description.inertia;
      mass = I.mass;
      first_moment = I.mass_center;
      report.kinetic += 0.5 * I.mass * V.linear.squaredNorm() + V.linear.dot(V.angular.cross(I.mass_center)) +
                        0.5 * V.angular.dot(I.inertia * V.angular);
    }
    report.potential -= d_.gravity.dot(mass * body.X_WB.p + body.X_WB.R * first_moment);
  }
  Powers powers;
  for (std::size_t i = 0; i < d_.forces.size(); ++i) {
    own_states(i, work);
    d_.forces[i]->add_powers(work.kin, work.signals.data(), powers);
  }
  report.potential += powers.potential;
  report.input_power += powers.input;
  report.dissipated_power += powers.dissipated;
  // The constraint forces -G^T lambda have the power -lambda . G v = lambda . g_t.
  for (std::size_t k = 0; k < constraints_.size(); ++k)
    constraints_[k]->rate(work.kin, work.rows_g.data() + first_row_[k]);
  for (std::size_t i = 0; i < kept_rows_.size(); ++i)
    report.input_power += lambda[i] * work.rows_g(kept_rows_[i]);
  return report;
}

EnergyReport Mechanism::energy(const State& s, ConstVectorRef, Scratch& scratch) const {
  Work& work = work_of(scratch);
  forward(Level::velocity, s.t, s.p.data(), s.v.data(), nullptr, work);
  deform_inertia(work);
  take_states(s, work);
  evaluate_signals(work);
  return energies(s.lambda.data(), work);
}

bool Mechanism::is_holonomic(int row) const {
  const int full = kept_rows_[row];
  const std::size_t k = constraint_of_row(full);
  return constraints_[k]->is_holonomic(full - first_row_[k]);
}

bool Mechanism::is_reversed(int joint) const {
  for (int b : order_)
    if (bodies_[b].joint == joint) return bodies_[b].reversed;
  return false;
}

double Mechanism::position_scale(int i) const {
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    if (i >= body.i_p && i < body.i_p + body.m) return 1.0 / d_.bodies[b].flexible->amplitude(i - body.i_p);
  }
  return 1.0;
}

double Mechanism::velocity_scale(int i) const {
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    if (i >= body.i_v && i < body.i_v + body.m) return 1.0 / d_.bodies[b].flexible->amplitude(i - body.i_v);
  }
  return 1.0;
}

double Mechanism::rate_scale(int i) const {
  // Markers that vibrate take their joints along, and through the reactions all that hangs on them: every
  // rate may be wrong by the highest frequency times the amplitude allowed.  Slow motion is held by its
  // positions.
  double omega = 1.0;
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    if (body.m == 0) continue;
    const FlexibleBody& flexible = *d_.bodies[b].flexible;
    if (i >= body.i_v && i < body.i_v + body.m)
      return std::max(1.0, std::sqrt(flexible.spring(i - body.i_v).stiffness)) * velocity_scale(i);
    for (int k = 0; k < body.m; ++k) omega = std::max(omega, std::sqrt(flexible.spring(k).stiffness));
  }
  return omega * velocity_scale(i);
}

std::string Mechanism::name_of_position(int i) const {
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    const JointPlace& place = places_[body.joint];
    if (i < body.i_p)
      return d_.joints[body.joint].name + "." + place.joint->coordinates()[i - place.i_p].name;
    if (i < body.i_p + body.m) return fmt::format("{}.mode_{}", d_.bodies[b].name, i - body.i_p + 1);
  }
  return {};
}

std::string Mechanism::name_of_velocity(int i) const {
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    const JointPlace& place = places_[body.joint];
    if (i < body.i_v) return d_.joints[body.joint].name + "." + place.joint->speeds()[i - place.i_v].name;
    if (i < body.i_v + body.m) return fmt::format("{}.mode_{}_rate", d_.bodies[b].name, i - body.i_v + 1);
  }
  return {};
}

std::string Mechanism::name_of_dynamic(int i) const {
  for (int b : order_) {
    const int k = i - bodies_[b].i_c, m = bodies_[b].i_c >= 0 ? bodies_[b].n_need : 0;
    if (k >= 0 && k < m) return fmt::format("{}.mode_{}", d_.bodies[b].name, k + 1);
    if (k >= m && k < 2 * m) return fmt::format("{}.mode_{}_rate", d_.bodies[b].name, k - m + 1);
  }
  if (i >= first_state_.back()) return name_of_force_state(i);
  std::size_t k = 0;
  while (first_state_[k + 1] <= i) ++k;
  const Control& control = *d_.controls[k];
  if (control.n_states() == 1) return control.name();
  return fmt::format("{}.state_{}", control.name(), i - first_state_[k] + 1);
}
std::string Mechanism::name_of_algebraic(int i) const {
  const int n = static_cast<int>(algebraic_.size());
  return i < n ? d_.controls[algebraic_[i]]->name() : constraints_[contacts_[i - n]]->name() + ".contact";
}

std::string Mechanism::name_of_constraint(int i) const {
  return name_of_row(kept_rows_[i]);
}

const double* Mechanism::modal_coordinates(int body, const State& s) const {
  if (bodies_[body].i_c >= 0) return s.c.data() + bodies_[body].i_c;
  return d_.bodies[body].flexible ? s.p.data() + bodies_[body].i_p : nullptr;
}

void Mechanism::body_poses(const State& s, Scratch& scratch, std::vector<Pose>& poses) const {
  Work& work = work_of(scratch);
  forward(Level::position, s.t, s.p.data(), nullptr, nullptr, work);
  poses.resize(d_.bodies.size());
  for (std::size_t b = 0; b < d_.bodies.size(); ++b) poses[b] = work.bodies[b].X_WB;
}

}  // namespace flexura::mbs
