// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/tangents.hpp"

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
  g_p.setZero(n_.n_lambda, n_.n_p);
  h_p.setZero(n_.n_lambda, n_.n_p);
  z.setZero(n_z);
  z_plus_ = z_minus_ = z;
  g_.setZero(n_.n_lambda);
  h_ = g_plus_ = h_plus_ = g_minus_ = h_minus_ = g_;
}

void Tangents::momentum(const State& s, const Eigen::VectorXd& v_dot, Eigen::VectorXd& out) {
  eq_.momentum(s, v_dot, *scratch_, out.head(n_.n_v), out.segment(n_.n_v, n_.n_dyn), out.tail(n_.n_alg));
  ++evaluations;
}

void Tangents::difference(Eigen::VectorXd& x, double scale_floor, int j, bool central,
                          const Eigen::VectorXd& v_dot, Eigen::MatrixXd& columns) {
  const double x_j = x(j);
  // Forward: sqrt(eps); central: eps^(1/3), the steps that balance round-off against truncation.
  const double h = (central ? 6e-6 : 1.5e-8) * std::max(std::abs(x_j), scale_floor);
  x(j) = x_j + h;
  const double up = x(j);
  momentum(s_, v_dot, z_plus_);
  if (central) {
    x(j) = x_j - h;
    momentum(s_, v_dot, z_minus_);
    columns.col(j) = (z_plus_ - z_minus_) / (up - x(j));
  } else {
    columns.col(j) = (z_plus_ - z) / (up - x_j);
  }
  x(j) = x_j;
}

void Tangents::evaluate(const State& s, const Eigen::VectorXd& v_dot, bool central) {
  s_ = s;
  eq_.mass_matrix(s.p, *scratch_, M);
  eq_.constraint_matrix(s.t, s.p, *scratch_, G);
  momentum(s_, v_dot, z);
  for (int j = 0; j < n_.n_p; ++j) difference(s_.p, eq_.position_scale(j), j, central, v_dot, z_p);
  for (int j = 0; j < n_.n_v; ++j) difference(s_.v, eq_.velocity_scale(j), j, central, v_dot, z_v);
  for (int j = 0; j < n_.n_dyn; ++j) difference(s_.c, 1.0, j, central, v_dot, z_c);
  for (int j = 0; j < n_.n_alg; ++j) difference(s_.a, 1.0, j, central, v_dot, z_a);
  if (n_.n_lambda == 0) return;
  eq_.position_constraints(s.t, s_.p, *scratch_, g_);
  eq_.velocity_constraints(s.t, s_.p, s.v, *scratch_, h_);
  for (int j = 0; j < n_.n_p; ++j) {
    const double p_j = s_.p(j),
                 h = (central ? 6e-6 : 1.5e-8) * std::max(std::abs(p_j), eq_.position_scale(j));
    s_.p(j) = p_j + h;
    const double up = s_.p(j);
    eq_.position_constraints(s.t, s_.p, *scratch_, g_plus_);
    eq_.velocity_constraints(s.t, s_.p, s.v, *scratch_, h_plus_);
    if (central) {
      s_.p(j) = p_j - h;
      eq_.position_constraints(s.t, s_.p, *scratch_, g_minus_);
      eq_.velocity_constraints(s.t, s_.p, s.v, *scratch_, h_minus_);
      g_p.col(j) = (g_plus_ - g_minus_) / (up - s_.p(j));
      h_p.col(j) = (h_plus_ - h_minus_) / (up - s_.p(j));
    } else {
      g_p.col(j) = (g_plus_ - g_) / (up - p_j);
      h_p.col(j) = (h_plus_ - h_) / (up - p_j);
    }
    s_.p(j) = p_j;
  }
}

}  // namespace flexura::mbs
