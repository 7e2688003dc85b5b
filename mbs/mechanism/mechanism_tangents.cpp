// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/mechanism_tangents.hpp"

#include <algorithm>
#include <cmath>

#include "mbs/base/math/differences.hpp"

namespace flexura::mbs {

using Eigen::MatrixXd;

void MechanismTangents::evaluate(const State& s, ConstVectorRef v_dot, TangentScope scope,
                                 MechanismScratch& work, TangentMatrices& out) const {
  const bool with_modes = m_.tree.n_flx > 0 && scope == TangentScope::everything;
  if (!work.tangents) size(work);
  MechanismScratch::Tangents& T = *work.tangents;
  residual_.move(TreeMotion::Level::acceleration, s, v_dot.data(), work);
  residual_.observe(s, work);
  m_.dynamics.body_forces(work.motion, work.wrenches);
  for (Spatial& load : work.wrenches.on_marker) load = {};
  // Loads of elements that are differenced stay out: their differences hold the turning of the bodies too.
  residual_.element_loads(s, Which::with_derivatives, T.z.segment(m_.tree.n_v, m_.tree.n_dyn),
                          T.z.tail(m_.n_algebraic()), work);
  m_.dynamics.backward(work.motion, work.wrenches, T.z.data());
  m_.inertia.vary_joints(work.motion, T.inertia);
  m_.dynamics.set_deformations(work.motion, work.wrenches);
  m_.mass.own_inertia(work.motion, work.wrenches, work.inertias);
  m_.inertia.vary_inertia(work.motion, work.wrenches, work.inertias, T.inertia);
  MatrixXd &z_q = T.elements.z_q, &h_q = T.elements.h_q;
  z_q.setZero();
  h_q.setZero();
  for (MatrixXd* m : {&out.z_v, &out.z_c, &out.z_a}) m->setZero();
  if (m_.followed.any())
    for (MatrixXd* m : {&out.g_c, &out.h_c})
      m->setZero(static_cast<Eigen::Index>(m_.rows.kept().size()), m_.tree.n_dyn);
  if (with_modes) m_.modes.mode_columns(work.motion, work.wrenches, T.inertia, z_q, out.z_v);
  m_.inertia.joint_columns(with_modes, T.inertia, z_q, out.z_v);
  m_.modes.following_columns(work.motion, work.wrenches, T.inertia, out.z_c);
  ElementTangents elements(m_.tree, m_.states, m_.rows, scope,
                           {work.motion, work.signals, work.rows, T.inertia, T.elements}, out);
  elements.all_signals();
  elements.all_elements();
  elements.all_followed(m_.followed);
  difference_elements(s, scope, work, out);
  difference_following(s, v_dot, work, out);
  m_.coordinates.take_to_coordinates(s.p.data(), z_q, out.z_p);
  m_.coordinates.take_to_coordinates(s.p.data(), h_q, out.h_p);
}

void MechanismTangents::size(MechanismScratch& work) const {
  work.tangents = std::make_unique<MechanismScratch::Tangents>();
  MechanismScratch::Tangents& T = *work.tangents;
  m_.inertia.size(T.inertia);
  T.elements.size(m_.tree, m_.states, m_.rows, m_.n_algebraic());
  T.z.setZero(m_.tree.n_v + m_.tree.n_dyn + m_.n_algebraic());
  T.z_plus = T.z;
  T.h.setZero(static_cast<Eigen::Index>(m_.rows.kept().size()));
  T.h_plus = T.h;
  T.step.setZero(m_.tree.n_v);
}

// Central differences of what the elements do.
void MechanismTangents::difference_elements(const State& s, TangentScope scope, MechanismScratch& work,
                                            TangentMatrices& out) const {
  const auto& constraints = m_.rows.constraints();
  const auto wants_differences = [](const auto& element) { return !element->has_derivatives(); };
  if (std::ranges::none_of(m_.tree.d.forces, wants_differences) &&
      std::ranges::none_of(constraints, wants_differences))
    return;
  constexpr double h = kCentralStep;
  MechanismScratch::Tangents& T = *work.tangents;
  State& moved = T.moved;
  moved = s;
  const auto evaluate = [&](Eigen::VectorXd& z, Eigen::VectorXd& h_rows) {
    residual_.move(TreeMotion::Level::velocity, moved, nullptr, work);
    m_.dynamics.clear_loads(work.wrenches);
    z.setZero();
    work.rows.g.setZero();
    residual_.observe(moved, work);
    residual_.element_loads(moved, Which::without_derivatives, z.segment(m_.tree.n_v, m_.tree.n_dyn),
                            z.tail(m_.n_algebraic()), work);
    m_.dynamics.backward(work.motion, work.wrenches, z.data());
    for (std::size_t k = 0; k < constraints.size(); ++k) {
      if (constraints[k]->has_derivatives()) continue;
      m_.rows.own_contact(k, work.motion, work.rows);
      constraints[k]->velocity(work.motion.kin, work.rows.g.data() + m_.rows.first_row(k));
    }
    const std::vector<int>& kept = m_.rows.kept();
    for (std::size_t i = 0; i < kept.size(); ++i) h_rows(i) = work.rows.g(kept[i]);
  };
  const auto add = [&](double step, auto&& column, auto&& column_h) {
    column += (T.z_plus - T.z) / (2.0 * step);
    column_h += (T.h_plus - T.h) / (2.0 * step);
  };
  for (int b : m_.tree.order) {
    const JointPlace& place = m_.tree.places[m_.tree.bodies[b].joint];
    const int end = m_.tree.bodies[b].i_v + (scope == TangentScope::everything ? m_.tree.bodies[b].m : 0);
    for (int j = place.i_v; j < end; ++j) {
      T.step(j) = h;
      m_.coordinates.retract(s.p, T.step, moved.p);
      evaluate(T.z_plus, T.h_plus);
      T.step(j) = -h;
      m_.coordinates.retract(s.p, T.step, moved.p);
      evaluate(T.z, T.h);
      T.step(j) = 0.0;
      moved.p = s.p;
      add(h, T.elements.z_q.col(j), T.elements.h_q.col(j));
    }
  }
  const auto along = [&](Eigen::VectorXd& x, int j, auto&& column) {
    const double x_j = x(j), step = h * std::max(1.0, std::abs(x_j));
    x(j) = x_j + step;
    evaluate(T.z_plus, T.h_plus);
    x(j) = x_j - step;
    evaluate(T.z, T.h);
    x(j) = x_j;
    column += (T.z_plus - T.z) / (2.0 * step);
  };
  for (int j = 0; j < m_.tree.n_v; ++j)
    if (scope == TangentScope::everything || !T.elements.is_elastic[j]) along(moved.v, j, out.z_v.col(j));
  for (int j = 0; j < m_.tree.n_dyn; ++j) {
    along(moved.c, j, out.z_c.col(j));
    if (out.h_c.size() > 0) out.h_c.col(j) += (T.h_plus - T.h) / (2.0 * h * std::max(1.0, std::abs(s.c(j))));
  }
  for (Eigen::Index j = 0; j < s.a.size(); ++j) along(moved.a, static_cast<int>(j), out.z_a.col(j));
}

// Rates of deformations that do not act back, and equations of measures of accelerations and reactions, by the motion and
// by the states of others: central differences, of which rigid bodies have few.  By accelerations, which act linearly,
// unit steps are exact.
void MechanismTangents::difference_following(const State& s, ConstVectorRef v_dot, MechanismScratch& work,
                                             TangentMatrices& out) const {
  const int first = m_.tree.n_own, n = m_.tree.n_dyn - first,
            n_coupled = static_cast<int>(m_.states.coupled_measures().size()),
            at_coupled = m_.tree.n_v + m_.tree.n_dyn + static_cast<int>(m_.states.algebraic().size());
  if (n == 0 && n_coupled == 0) return;
  MechanismScratch::Tangents& T = *work.tangents;
  State& moved = T.moved;
  moved = s;
  const auto evaluate = [&](ConstVectorRef at_v_dot, Eigen::VectorXd& z) {
    residual_.momentum(moved, at_v_dot, work, z.head(m_.tree.n_v), z.segment(m_.tree.n_v, m_.tree.n_dyn),
                       z.tail(z.size() - m_.tree.n_v - m_.tree.n_dyn));
  };
  const auto change = [&](double step) { return (T.z_plus - T.z).segment(m_.tree.n_v + first, n) / step; };
  const auto coupled = [&](double step) { return (T.z_plus - T.z).segment(at_coupled, n_coupled) / step; };
  for (int j = 0; j < m_.tree.n_v; ++j) {
    T.step(j) = kCentralStep;
    m_.coordinates.retract(s.p, T.step, moved.p);
    evaluate(v_dot, T.z_plus);
    T.step(j) = -kCentralStep;
    m_.coordinates.retract(s.p, T.step, moved.p);
    evaluate(v_dot, T.z);
    T.step(j) = 0.0;
    moved.p = s.p;
    T.elements.z_q.col(j).segment(m_.tree.n_v + first, n) = change(2.0 * kCentralStep);
    T.elements.z_q.col(j).segment(at_coupled, n_coupled) = coupled(2.0 * kCentralStep);
  }
  const auto along = [&](Eigen::VectorXd& x, Eigen::Index j, auto&& column) {
    const double x_j = x(j), step = kCentralStep * std::max(1.0, std::abs(x_j));
    x(j) = x_j + step;
    evaluate(v_dot, T.z_plus);
    x(j) = x_j - step;
    evaluate(v_dot, T.z);
    x(j) = x_j;
    if (&x != &moved.c || j < first) column.segment(m_.tree.n_v + first, n) = change(2.0 * step);
    column.segment(at_coupled, n_coupled) = coupled(2.0 * step);
  };
  for (int j = 0; j < m_.tree.n_v; ++j) along(moved.v, j, out.z_v.col(j));
  for (int j = 0; j < (n_coupled > 0 ? m_.tree.n_dyn : first); ++j) along(moved.c, j, out.z_c.col(j));
  for (Eigen::Index j = 0; j < s.a.size(); ++j) along(moved.a, j, out.z_a.col(j));

  if (n > 0) {
    out.c_v_dot.setZero(m_.tree.n_dyn, m_.tree.n_v);
    out.c_lambda.setZero(m_.tree.n_dyn, s.lambda.size());
  }
  if (n_coupled > 0) {
    out.b_v_dot.setZero(m_.n_algebraic(), m_.tree.n_v);
    out.b_lambda.setZero(m_.n_algebraic(), s.lambda.size());
  }
  const auto in_b = static_cast<Eigen::Index>(m_.states.algebraic().size());
  const auto store = [&](MatrixXd& of_c, MatrixXd& of_b, Eigen::Index column, double of_step) {
    if (n > 0) of_c.col(column).tail(n) = change(of_step);
    if (n_coupled > 0) of_b.col(column).segment(in_b, n_coupled) = coupled(of_step);
  };
  evaluate(v_dot, T.z);
  T.step = v_dot;
  for (int j = 0; j < m_.tree.n_v; ++j) {
    T.step(j) += 1.0;
    evaluate(T.step, T.z_plus);
    T.step(j) = v_dot(j);
    store(out.c_v_dot, out.b_v_dot, j, 1.0);
  }
  T.step.setZero();
  // Sizes of reactions bend where these vanish: steps small beside them.
  const double largest = s.lambda.size() > 0 ? s.lambda.lpNorm<Eigen::Infinity>() : 0.0,
               step = largest > 0.0 ? 1e-3 * largest : 1.0;
  for (Eigen::Index k = 0; k < s.lambda.size(); ++k) {
    moved.lambda(k) = s.lambda(k) + step;
    evaluate(v_dot, T.z_plus);
    moved.lambda(k) = s.lambda(k) - step;
    evaluate(v_dot, T.z);
    moved.lambda(k) = s.lambda(k);
    store(out.c_lambda, out.b_lambda, k, 2.0 * step);
  }
}

}  // namespace flexura::mbs
