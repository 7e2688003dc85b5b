// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/tangents.hpp"

#include <cmath>

namespace flexura::mbs {

Tangents::Tangents(const Equations& eq) : eq_(eq), n_(eq.sizes()), scratch_(eq.make_scratch()) {
  const int n_z = n_.n_v + n_.n_dyn + n_.n_alg;
  z_p.setZero(n_z, n_.n_p);
  z_v.setZero(n_z, n_.n_v);
  z_c.setZero(n_z, n_.n_dyn);
  z_a.setZero(n_z, n_.n_alg);
  M.setZero(n_.n_v, n_.n_v);
  G.setZero(n_.n_lambda, n_.n_v);
  h_p.setZero(n_.n_lambda, n_.n_p);
  z_.setZero(n_z);
  z_plus_ = z_;
  h_.setZero(n_.n_lambda);
  h_plus_ = h_;
  position_scale_.resize(n_.n_p);
  velocity_scale_.resize(n_.n_v);
  for (int i = 0; i < n_.n_p; ++i) position_scale_(i) = eq.position_scale(i);
  elastic_p_.assign(n_.n_p, false);
  elastic_v_.assign(n_.n_v, false);
  for (int i = 0; i < n_.n_v; ++i) {
    velocity_scale_(i) = eq.velocity_scale(i);
    Elastic e{-1, i, 0.0, 0.0};
    if (!eq.elastic_coordinate(i, e.i_p, e.stiffness, e.damping)) continue;
    elastic_.push_back(e);
    bends_far_ = bends_far_ || !(e.stiffness > 0.0);
    elastic_p_[e.i_p] = elastic_v_[i] = true;
  }
}

void Tangents::momentum(const State& s, const Eigen::VectorXd& v_dot, Eigen::VectorXd& out) {
  eq_.momentum(s, v_dot, *scratch_, out.head(n_.n_v), out.segment(n_.n_v, n_.n_dyn), out.tail(n_.n_alg));
  ++evaluations;
}

// sqrt(eps) balances round-off against truncation.
double Tangents::step_of(double x, double scale) const {
  return 1.5e-8 * std::max(std::abs(x), scale);
}

void Tangents::difference(Eigen::VectorXd& x, double scale_floor, int j, const Eigen::VectorXd& v_dot,
                          Eigen::MatrixXd& columns) {
  const double x_j = x(j);
  x(j) = x_j + step_of(x_j, scale_floor);
  const double up = x(j);
  momentum(s_, v_dot, z_plus_);
  columns.col(j) = (z_plus_ - z_) / (up - x_j);
  x(j) = x_j;
}

void Tangents::by_differences(const Eigen::VectorXd& v_dot, bool skips) {
  momentum(s_, v_dot, z_);
  for (int j = 0; j < n_.n_p; ++j)
    if (!skips || !elastic_p_[j]) difference(s_.p, position_scale_(j), j, v_dot, z_p);
  for (int j = 0; j < n_.n_v; ++j)
    if (!skips || !elastic_v_[j]) difference(s_.v, velocity_scale_(j), j, v_dot, z_v);
  for (int j = 0; j < n_.n_dyn; ++j) difference(s_.c, 1.0, j, v_dot, z_c);
  for (int j = 0; j < n_.n_alg; ++j) difference(s_.a, 1.0, j, v_dot, z_a);
  if (n_.n_lambda == 0) return;
  eq_.velocity_constraints(s_, s_.p, s_.v, *scratch_, h_);
  for (int j = 0; j < n_.n_p; ++j) {
    if (skips && elastic_p_[j]) {
      h_p.col(j).setZero();
      continue;
    }
    const double p_j = s_.p(j);
    s_.p(j) = p_j + step_of(p_j, position_scale_(j));
    eq_.velocity_constraints(s_, s_.p, s_.v, *scratch_, h_plus_);
    h_p.col(j) = (h_plus_ - h_) / (s_.p(j) - p_j);
    s_.p(j) = p_j;
  }
}

void Tangents::evaluate(const State& s, const Eigen::VectorXd& v_dot, TangentScope scope) {
  const bool skips = scope == TangentScope::newton;
  eq_.mass_matrix(s.p, *scratch_, M);
  eq_.constraint_matrix(s, s.p, *scratch_, G);
  if (eq_.tangents(s, v_dot, scope, *scratch_, *this)) {
    ++evaluations;
  } else {
    s_ = s;
    by_differences(v_dot, skips);
  }
  if (skips) set_elastic_columns(s);
}

void Tangents::set_elastic_columns(const State& s) {
  for (const Elastic& e : elastic_) {
    z_p.col(e.i_p).setZero();
    z_v.col(e.i_v).setZero();
    z_p(e.i_v, e.i_p) = e.stiffness;
    z_v(e.i_v, e.i_v) = e.damping;
  }
  eq_.add_elastic_tangents(s, z_p.topRows(n_.n_v), z_v.topRows(n_.n_v));
}

}  // namespace flexura::mbs
