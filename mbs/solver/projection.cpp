// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/projection.hpp"

#include <cmath>

namespace flexura::mbs {

Projector::Projector(const Equations& eq) : eq_(eq), n_(eq.sizes()), scratch_(eq.make_scratch()) {
  M_.setZero(n_.n_v, n_.n_v);
  G_.setZero(n_.n_lambda, n_.n_v);
  g_.setZero(n_.n_lambda);
  zero_.setZero(n_.n_v);
  p_.setZero(n_.n_p);
  scale_.resize(n_.n_v);
  for (int i = 0; i < n_.n_v; ++i) scale_(i) = eq.velocity_scale(i);
}

bool Projector::project(State& s) {
  // A zero move normalises quaternions.
  eq_.retract(s.p, zero_, p_);
  s.p = p_;
  if (n_.n_lambda == 0) return s.p.allFinite() && s.v.allFinite();
  eq_.mass_matrix(s.p, *scratch_, M_);
  eq_.constraint_matrix(s.t, s.p, *scratch_, G_);
  if (!M_.allFinite() || !G_.allFinite()) return false;
  saddle_.factor(eq_, M_, G_);
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 10; ++iteration) {
    eq_.position_constraints(s.t, s.p, *scratch_, g_);
    const double now = g_.cwiseProduct(saddle_.row_scale()).norm();
    if (!std::isfinite(now)) return false;
    if (now == 0.0) break;
    if (iteration > 0 && now > 0.5 * before) {
      // Either at round-off, or diverging from too far away.
      if ((g_.cwiseAbs().array() > 1e-11 * (G_.cwiseAbs() * scale_).array() + 1e-300).any()) return false;
      break;
    }
    before = now;
    g_ = -g_;
    saddle_.solve(zero_, g_, d_, x_);
    eq_.retract(s.p, d_, p_);
    s.p = p_;
  }
  eq_.mass_matrix(s.p, *scratch_, M_);
  eq_.constraint_matrix(s.t, s.p, *scratch_, G_);
  saddle_.factor(eq_, M_, G_);
  eq_.velocity_constraints(s.t, s.p, s.v, *scratch_, g_);
  g_ = -g_;
  saddle_.solve(zero_, g_, d_, x_);
  s.v += d_;
  return s.p.allFinite() && s.v.allFinite();
}

}  // namespace flexura::mbs
