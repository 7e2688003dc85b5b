// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/LU>
#include <algorithm>

#include "mbs/base/math/differences.hpp"
#include "mbs/mechanism/element_tangents.hpp"

/// The tangent matrices: inertia in closed form (inertia_tangents.cpp), then what elements add.
namespace flexura::mbs {

using Eigen::MatrixXd;

bool Mechanism::tangents(const State& s, ConstVectorRef v_dot, TangentScope scope, Scratch& scratch,
                         TangentMatrices& out) const {
  const bool with_modes = n_flx_ > 0 && scope == TangentScope::everything;
  Work& work = work_of(scratch);
  Work::Tangent& T = work.tangent;
  if (T.bodies.empty()) size_tangents(work);
  forward(Level::acceleration, s.t, s.p.data(), s.v.data(), v_dot.data(), work);
  take_states(s, work);
  body_forces(true, work);
  evaluate_signals(work);
  for (Work::LocalMarker& marker : work.local) marker.load = {};
  // Loads of elements that are differenced stay out: their differences hold the turning of the bodies too.
  element_loads(s, Which::with_derivatives, T.z.segment(n_v_, n_dyn_), T.z.tail(sizes().n_alg), work);
  backward(work, T.z.data());
  vary_joints(work);
  vary_inertia(work);
  T.z_q.setZero();
  T.h_q.setZero();
  for (MatrixXd* m : {&out.z_v, &out.z_c, &out.z_a}) m->setZero();
  if (with_modes) mode_tangents(work, T.z_q, out.z_v);
  inertia_tangents(with_modes, work, T.z_q, out.z_v);
  following_tangents(work, out.z_c);
  ElementDerivatives elements(*this, scope, work, out);
  elements.all_signals();
  elements.all_elements();
  difference_elements(s, scope, work, out);
  difference_following(s, v_dot, work, out);
  take_to_coordinates(s.p.data(), T.z_q, out.z_p);
  take_to_coordinates(s.p.data(), T.h_q, out.h_p);
  return true;
}

// At the first use: most scratches never see one.
void Mechanism::size_tangents(Work& work) const {
  Work::Tangent& T = work.tangent;
  const Sizes n = sizes();
  T.bodies.resize(d_.bodies.size());
  T.deformations.resize(d_.bodies.size());
  T.markers.resize(d_.markers.size());
  int widest = 0;
  for (int b : order_) {
    if (const auto& flexible = d_.bodies[b].flexible) T.deformations[b] = flexible->make_deformation_tangents();
    if (bodies_[b].m == 0) continue;
    widest = std::max(widest, bodies_[b].m);
    for (const int i : markers_of_body_[b])
      if (is_carried_[i])
        for (Work::Columns6* x : {&T.markers[i].eta, &T.markers[i].D, &T.markers[i].E, &T.markers[i].E_v})
          x->setZero(6, bodies_[b].m);
  }
  T.G_p.setZero(6, widest);
  T.G_v.setZero(6, widest);
  for (int b : order_) {
    T.bodies[b].modal_w.setZero(bodies_[b].m, 3);
    T.bodies[b].depth = T.bodies[bodies_[b].parent].depth + 1;
  }
  for (Work::Columns6* m : {&T.phi, &T.D, &T.E, &T.E_v, &T.row_E, &T.H_p, &T.H_v}) m->setZero(6, n_v_);
  T.row_w.setZero(3, n_v_);
  T.is_elastic.assign(n_v_, false);
  for (int b : order_)
    for (int l = 0; l < bodies_[b].m; ++l) T.is_elastic[bodies_[b].i_v + l] = true;
  T.kept.assign(first_row_.back(), -1);
  for (std::size_t i = 0; i < kept_rows_.size(); ++i) T.kept[kept_rows_[i]] = static_cast<int>(i);
  Work::ElementTangent& E = work.element;
  for (Work::Reach* reach : {&E.at, &E.axes, &E.reaction, &E.seen_F, &E.seen_M}) {
    reach->twist.setZero(6, n_v_);
    reach->D.setZero(6, n_v_);
    reach->rigid.setZero(6, n_v_);
    reach->list.reserve(n_v_);
  }
  E.mark.assign(n_v_, 0);
  E.columns.reserve(n_v_);
  E.seen_columns.reserve(n_v_);
  E.rows.reserve(n_v_ + 6);
  E.by_row.setZero(6, n_v_ + 6);
  E.motion.setZero(12, n_v_);
  if (!used_signals_.empty()) E.signals.setZero(d_.signals.size(), 2 * n_v_ + n.n_dyn + n.n_alg);
  T.z.setZero(n_v_ + n.n_dyn + n.n_alg);
  T.z_plus = T.z;
  T.h.setZero(n.n_lambda);
  T.h_plus = T.h;
  T.step.setZero(n_v_);
  T.z_q.setZero(T.z.size(), n_v_);
  T.h_q.setZero(n.n_lambda, n_v_);
}

// What each signal depends on, in the order in which they are evaluated.
void Mechanism::ElementDerivatives::all_signals() {
  const double* signals = work_.signals.data();
  for (const int k : m_.used_signals_) {
    const SignalSource& source = m_.sources_[k];
    signal_ = k;
    switch (source.kind) {
      case SignalSource::Kind::time:
      case SignalSource::Kind::input:
        break;
      case SignalSource::Kind::coordinate:
        rows();
        Derivatives::by_coordinate(source.coordinate, 1.0);
        break;
      case SignalSource::Kind::speed:
        rows();
        Derivatives::by_speed(source.coordinate, 1.0);
        break;
      case SignalSource::Kind::measure:
        m_.d_.measures[source.element]->differentiate(work_.kin, signals, *this);
        break;
      case SignalSource::Kind::control: {
        const Control& control = *m_.d_.controls[source.element];
        first_state_ = m_.first_state_[source.element];
        if (!control.is_algebraic()) {
          control.differentiate(signals, work_.kin.c + first_state_, *this);
          break;
        }
        rows();
        algebraic_ =
            static_cast<int>(std::ranges::find(m_.algebraic_, source.element) - m_.algebraic_.begin());
        by_algebraic(1.0);
        algebraic_ = -1;
      }
    }
  }
  signal_ = -1;
}

void Mechanism::ElementDerivatives::all_elements() {
  const double* signals = work_.signals.data();
  for (std::size_t i = 0; i < m_.d_.controls.size(); ++i) {
    first_state_ = m_.first_state_[i];
    m_.d_.controls[i]->differentiate_rates(signals, work_.kin.c + first_state_, *this);
  }
  for (std::size_t i = 0; i < m_.d_.forces.size(); ++i) {
    if (!m_.d_.forces[i]->has_derivatives()) continue;
    m_.own_states(i, work_);
    first_state_ = m_.first_force_state_[i];
    m_.d_.forces[i]->differentiate(work_.kin, signals, *this);
  }
  for (std::size_t k = 0; k < m_.algebraic_.size(); ++k) {
    algebraic_ = static_cast<int>(k);
    m_.d_.controls[m_.algebraic_[k]]->differentiate(signals, nullptr, *this);
  }
  for (std::size_t k = 0; k < m_.contacts_.size(); ++k) {
    algebraic_ = static_cast<int>(m_.algebraic_.size() + k);
    m_.constraints_[m_.contacts_[k]]->differentiate_contact(work_.kin, work_.algebraic(algebraic_), *this);
  }
  algebraic_ = -1;
  factor_ = -1.0;
  for (std::size_t k = 0; k < m_.constraints_.size(); ++k) {
    const Constraint& constraint = *m_.constraints_[k];
    if (!constraint.has_derivatives()) continue;
    m_.own_contact(k, work_);
    first_row_ = m_.first_row_[k];
    n_rows_ = constraint.n_rows();
    constraint.differentiate(work_.kin, work_.rows_x.data() + first_row_, *this);
  }
}

// Central differences of what the elements do.
void Mechanism::difference_elements(const State& s, TangentScope scope, Work& work,
                                    TangentMatrices& out) const {
  const auto wants_differences = [](const auto& element) { return !element->has_derivatives(); };
  if (std::ranges::none_of(d_.forces, wants_differences) &&
      std::ranges::none_of(constraints_, wants_differences))
    return;
  constexpr double h = kCentralStep;
  Work::Tangent& T = work.tangent;
  State& moved = T.moved;
  moved = s;
  const auto evaluate = [&](Eigen::VectorXd& z, Eigen::VectorXd& h_rows) {
    forward(Level::velocity, moved.t, moved.p.data(), moved.v.data(), nullptr, work);
    take_states(moved, work);
    clear_loads(work);
    z.setZero();
    work.rows_g.setZero();
    evaluate_signals(work);
    element_loads(moved, Which::without_derivatives, z.segment(n_v_, n_dyn_), z.tail(sizes().n_alg), work);
    backward(work, z.data());
    for (std::size_t k = 0; k < constraints_.size(); ++k) {
      if (constraints_[k]->has_derivatives()) continue;
      own_contact(k, work);
      constraints_[k]->velocity(work.kin, work.rows_g.data() + first_row_[k]);
    }
    for (std::size_t i = 0; i < kept_rows_.size(); ++i) h_rows(i) = work.rows_g(kept_rows_[i]);
  };
  const auto add = [&](double step, auto&& column, auto&& column_h) {
    column += (T.z_plus - T.z) / (2.0 * step);
    column_h += (T.h_plus - T.h) / (2.0 * step);
  };
  for (int b : order_) {
    const JointPlace& place = places_[bodies_[b].joint];
    const int end = bodies_[b].i_v + (scope == TangentScope::everything ? bodies_[b].m : 0);
    for (int j = place.i_v; j < end; ++j) {
      T.step(j) = h;
      retract(s.p, T.step, moved.p);
      evaluate(T.z_plus, T.h_plus);
      T.step(j) = -h;
      retract(s.p, T.step, moved.p);
      evaluate(T.z, T.h);
      T.step(j) = 0.0;
      moved.p = s.p;
      add(h, T.z_q.col(j), T.h_q.col(j));
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
  for (int j = 0; j < n_v_; ++j)
    if (scope == TangentScope::everything || !T.is_elastic[j]) along(moved.v, j, out.z_v.col(j));
  for (int j = 0; j < n_dyn_; ++j) along(moved.c, j, out.z_c.col(j));
  for (Eigen::Index j = 0; j < s.a.size(); ++j) along(moved.a, static_cast<int>(j), out.z_a.col(j));
}

// by_p = by_tangent T^+, T^+ the inverse of p' = T v on the manifold: how p's own numbers change them.
void Mechanism::take_to_coordinates(const double* p, const MatrixXd& by_tangent, MatrixXd& by_p) const {
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 7, 6> N;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 7> N_plus;
  for (int b : order_) {
    const TreeBody& t = bodies_[b];
    const JointPlace& place = places_[t.joint];
    const int n_p = place.joint->n_p(), n_v = place.joint->n_v();
    N.resize(n_p, n_v);
    for (int j = 0; j < n_v; ++j) {
      const Eigen::Matrix<double, 6, 1> e = Eigen::Matrix<double, 6, 1>::Unit(j);
      place.joint->kinematic(p + place.i_p, e.data(), N.col(j).data());
    }
    const auto from = by_tangent.middleCols(place.i_v, n_v);
    auto to = by_p.middleCols(place.i_p, n_p);
    if (n_p == n_v && N.isIdentity(0.0)) {
      to = from;
    } else {
      const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> gram = N.transpose() * N;
      N_plus = gram.inverse() * N.transpose();
      to.noalias() = from.lazyProduct(N_plus);
    }
    by_p.middleCols(t.i_p, t.m) = by_tangent.middleCols(t.i_v, t.m);
  }
}

}  // namespace flexura::mbs
