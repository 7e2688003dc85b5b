// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/watch/standstill.hpp"

#include <Eigen/QR>

#include "mbs/solver/accuracy/scales.hpp"
#include "mbs/solver/algebra/saddle.hpp"

namespace flexura::mbs {

double independence_of_rows(const Equations& eq, const State& s, Equations::Scratch& scratch, int* rank) {
  const Sizes n = eq.sizes();
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n.n_v, n.n_v), G = Eigen::MatrixXd::Zero(n.n_lambda, n.n_v);
  eq.mass_matrix(s.p, scratch, M);
  eq.constraint_matrix(s, s.p, scratch, G);
  SaddleSolver rows;
  rows.factor(eq, M, G);
  if (rank) *rank = static_cast<int>(rows.rank());
  return rows.independence();
}

double hold_of_rows(const Equations& eq, const State& s, Equations::Scratch& scratch) {
  const Sizes n = eq.sizes();
  if (n.n_lambda == 0) return 1.0;
  if (n.n_lambda > n.n_v) return 0.0;
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(n.n_lambda, n.n_v);
  eq.constraint_matrix(s, s.p, scratch, G);
  const Eigen::VectorXd size = eq.constraint_sizes(s, s.p, scratch).size.cwiseMax(1e-300);
  for (int i = 0; i < n.n_v; ++i) G.col(i) *= eq.velocity_scale(i);
  G = (size.cwiseInverse().asDiagonal() * G).eval();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(G.transpose());
  const auto R = qr.matrixR().diagonal().cwiseAbs();
  return R(0) > 0.0 ? R(n.n_lambda - 1) / R(0) : 0.0;
}

bool stands_still(const Equations& eq, const SolverOptions& options, const State& s,
                  Equations::Scratch& scratch) {
  constexpr double kHeld = 1e-6;    // of the rows' independence: what parts are made to
  constexpr double kClosed = 1e-8;  // and so much of the length: how far from a closed position it may stand
  constexpr int kGlances = 100;     // at rows that begin to move later
  const Sizes n = eq.sizes();
  if (n.n_v == 0 || n.n_lambda < n.n_v || n.n_dyn > 0 || n.n_alg > 0 || !s.v.isZero(1e-12)) return false;
  for (int k = 0; k < n.n_root; ++k)
    if (!eq.is_condition(k)) return false;
  for (int k = 0; k < n.n_lambda; ++k)
    if (!eq.is_holonomic(k)) return false;
  Eigen::VectorXd g_t(n.n_lambda);
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n.n_v);
  State then = s;  // rows that follow an input ask for the state
  for (int k = 0; k <= kGlances; ++k) {
    then.t = options.start_time + (options.end_time - options.start_time) * k / kGlances;
    eq.velocity_constraints(then, s.p, rest, scratch, g_t);
    if (!g_t.isZero(0.0)) return false;
  }
  int rank = 0;
  const double independence = independence_of_rows(eq, s, scratch, &rank);
  if (rank < n.n_v || !(independence > kHeld)) return false;
  // Where positions are closed near a double root, what is left open is far from closed along what the rows hardly
  // hold, and to close it once more would move it (a parallelogram whose third crank fits by 1e-10).
  Eigen::VectorXd g(n.n_lambda);
  eq.position_constraints(s, s.p, scratch, g);
  const double length = options.scales ? options.scales->length : 1.0;
  return g.lpNorm<Eigen::Infinity>() <= kClosed * length * independence;
}

}  // namespace flexura::mbs
