// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/solver/derivatives.hpp"

#include <gtest/gtest.h>

#include "mbs/solver/algebra/tangents.hpp"
#include "tests/mbs/model/checks.hpp"

namespace flexura::mbs::checks {
namespace {

// [r; c_rate; b; G v + g_t] of a state.
VectorXd everything(const Mechanism& m, const State& s, const VectorXd& v_dot, Equations::Scratch& scratch) {
  const Sizes n = m.sizes();
  VectorXd y(n.n_v + n.n_dyn + n.n_alg + n.n_lambda);
  m.momentum(s, v_dot, scratch, y.head(n.n_v), y.segment(n.n_v, n.n_dyn),
             y.segment(n.n_v + n.n_dyn, n.n_alg));
  m.velocity_constraints(s.t, s.p, s.v, scratch, y.tail(n.n_lambda));
  return y;
}

// Central differences of fourth order, D(h) = f' - h^4 f^(5) / 30 + ..., round-off 1.5 eps |f| / h.
void derivatives_agree(const Mechanism& m, State s, unsigned seed, TangentScope scope, double own_error) {
  const Sizes n = m.sizes();
  Random random(seed);
  VectorXd v_dot = random.vector(n.n_v);
  Tangents tangents(m);
  tangents.evaluate(s, v_dot, scope);
  const auto scratch = m.make_scratch();
  const VectorXd here = everything(m, s, v_dot, *scratch);
  const int n_z = n.n_v + n.n_dyn + n.n_alg;
  const auto compare = [&](VectorXd& x, const MatrixXd& columns, const MatrixXd* rows_h,
                           const std::vector<bool>& skips, const char* what) {
    for (int j = 0; j < x.size(); ++j) {
      if (!skips.empty() && skips[j]) continue;
      const double x_j = x(j);
      const auto at = [&](double step) {
        x(j) = x_j + step;
        VectorXd y = everything(m, s, v_dot, *scratch);
        x(j) = x_j;
        return y;
      };
      const auto difference = [&](double h) {
        return VectorXd((8.0 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12.0 * h));
      };
      const double h = 2.5e-4;
      const VectorXd D = difference(h), coarse = difference(2.0 * h);
      VectorXd own(here.size());
      own.head(n_z) = columns.col(j);
      own.tail(n.n_lambda) = rows_h ? VectorXd(rows_h->col(j)) : VectorXd(D.tail(n.n_lambda));
      // Truncation is a fifteenth of what halving the step changed; the terms beyond it may be as large
      // again. Round-off: 1.5 eps / h = 1.3e-12 of the largest numbers met on the way to f, some ten times f
      // itself.
      const double scale = 1.0 + here.cwiseAbs().maxCoeff() + D.cwiseAbs().maxCoeff();
      const double tolerance = (D - coarse).cwiseAbs().maxCoeff() / 7.0 + (2e-11 + own_error) * scale;
      EXPECT_LT((own - D).cwiseAbs().maxCoeff(), tolerance) << what << " " << j << ", scale " << scale;
      // The comparison must not become empty by differences that say nothing.
      EXPECT_LT(tolerance, (1e-7 + own_error) * scale) << what << " " << j;
    }
  };
  std::vector<bool> elastic_p, elastic_v;
  if (scope == TangentScope::newton) {
    elastic_p.assign(n.n_p, false);
    elastic_v.assign(n.n_v, false);
    for (int i = 0; i < n.n_v; ++i) {
      int i_p;
      double k, d;
      if (m.elastic_coordinate(i, i_p, k, d)) elastic_p[i_p] = elastic_v[i] = true;
    }
  }
  compare(s.p, tangents.z_p, n.n_lambda > 0 ? &tangents.h_p : nullptr, elastic_p, "by position");
  compare(s.v, tangents.z_v, n.n_lambda > 0 ? &tangents.G : nullptr, elastic_v, "by velocity");
  compare(s.c, tangents.z_c, nullptr, {}, "by dynamic state");
  compare(s.a, tangents.z_a, nullptr, {}, "by algebraic state");
  // M and G^T, and what dynamic states say to accelerations and reactions.
  MatrixXd by_v_dot = MatrixXd::Zero(n_z, n.n_v), by_lambda = MatrixXd::Zero(n_z, n.n_lambda);
  by_v_dot.topRows(n.n_v) = tangents.M;
  by_lambda.topRows(n.n_v) = tangents.G.transpose();
  if (tangents.c_v_dot.size() > 0) by_v_dot.middleRows(n.n_v, n.n_dyn) = tangents.c_v_dot;
  if (tangents.c_lambda.size() > 0) by_lambda.middleRows(n.n_v, n.n_dyn) = tangents.c_lambda;
  compare(v_dot, by_v_dot, nullptr, {}, "by acceleration");
  compare(s.lambda, by_lambda, nullptr, {}, "by multiplier");
}

}  // namespace

void derivatives_agree(const Mechanism& m, double own_error) {
  for (unsigned seed : {3u, 4u}) {
    State s = random_state(m, seed, 0.3);
    Random random(seed + 50);
    s.c += random.vector(static_cast<int>(s.c.size()), 0.2);
    s.a += random.vector(static_cast<int>(s.a.size()), 0.2);
    const auto scratch = m.make_scratch();
    m.start_contacts(s, *scratch);
    m.start_switches(s, *scratch);
    derivatives_agree(m, s, seed + 100, TangentScope::everything, own_error);
    if (m.sizes().n_flx > 0) derivatives_agree(m, s, seed + 100, TangentScope::newton, own_error);
  }
}

}  // namespace flexura::mbs::checks
