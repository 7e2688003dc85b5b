// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/response_modes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "reduce/cms/shapes/shape_change.hpp"
#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

void add_to(ExtraShapes& all, const ExtraShapes& more) {
  const Index before = all.X.cols();
  all.X.conservativeResize(more.X.rows(), before + more.X.cols());
  all.X.rightCols(more.X.cols()) = more.X;
  all.mass.conservativeResize(all.X.cols());
  all.mass.tail(more.X.cols()) = more.mass;
  all.energy.conservativeResize(all.X.cols());
  all.energy.tail(more.X.cols()) = more.energy;
  all.names.insert(all.names.end(), more.names.begin(), more.names.end());
}

ExtraShapes whole_shapes(const linalg::EigenProblem& problem, MatrixXd X, std::vector<std::string> names) {
  ExtraShapes out{.X = std::move(X), .mass = {}, .energy = {}, .names = std::move(names)};
  MatrixXd A_X;
  problem.multiply_M(out.X, A_X);
  out.mass = problem.inner(out.X, A_X).diagonal().cwiseMax(0.0);
  problem.multiply_K(out.X, A_X);
  out.energy = problem.inner(out.X, A_X).diagonal().cwiseMax(0.0);
  return out;
}

ExtraShapes response_shapes(const linalg::EigenProblem& problem, const linalg::EigenPairs& pairs,
                            const MatrixXd& Mhat, double omega, const std::vector<std::string>& names) {
  const double hertz = omega / (2.0 * std::numbers::pi);
  if (omega > 0.0 && !(pairs.omega2_next > 0.0))
    throw std::invalid_argument(
        fmt::format("response modes at {:.5g} Hz want the normal modes below it, but none are computed; keep "
                    "at least one "
                    "(count = 1), or ask for the response at 0 Hz",
                    hertz));
  // At rest the series below has one term, whatever is kept.
  const double ratio = omega > 0.0 ? omega * omega / pairs.omega2_next : 0.0;
  if (!(ratio < 0.64))
    throw std::invalid_argument(fmt::format(
        "response modes at {:.5g} Hz want all normal modes to {:.5g} Hz, the first left out is at {:.5g} Hz; "
        "keep more modes or choose a lower frequency",
        hertz, hertz / 0.8, std::sqrt(pairs.omega2_next) / (2.0 * std::numbers::pi)));
  MatrixXd M_Phi;
  problem.multiply_M(pairs.Phi, M_Phi);
  const auto without_modes = [&](MatrixXd& X) {
    if (pairs.Phi.cols() == 0) return;
    const MatrixXd share = problem.inner(M_Phi, X);
    linalg::add_product(-1.0, pairs.Phi, share, X);
  };
  const auto size = [&](const MatrixXd& X) { return std::sqrt(problem.inner(X, X).trace()); };
  std::vector<std::string> responses;
  for (const std::string& name : names)
    responses.push_back(fmt::format("response to {} at {:.5g} Hz", name, hertz));
  MatrixXd term, M_term;
  problem.solve(Mhat, term);
  // Where all modes are kept, what is left of the answers is round-off: only their sizes show it.
  ExtraShapes out = whole_shapes(problem, term, std::move(responses));
  without_modes(term);
  out.X = term;
  // To the digits that the solves have.
  for (int step = 0; step < 100 && ratio > 0.0; ++step) {
    problem.multiply_M(term, M_term);
    problem.solve(M_term, term);
    term *= omega * omega;
    without_modes(term);
    out.X += term;
    if (size(term) < 1e-10 * size(out.X)) break;
  }
  return out;
}

std::vector<std::string> append_shapes(const linalg::EigenProblem& problem, linalg::EigenPairs& pairs,
                                       const ExtraShapes& extra) {
  std::vector<std::string> dropped;
  const Index n = problem.n, n_q = pairs.Phi.cols();
  MatrixXd Q(n, n_q + extra.X.cols());
  Q.leftCols(n_q) = pairs.Phi;
  MatrixXd MQ(n, Q.cols()), M_block;
  problem.multiply_M(pairs.Phi, M_block);
  MQ.leftCols(n_q) = M_block;
  Index rank = n_q;
  for (Index j = 0; j < extra.X.cols(); ++j) {
    MatrixXd x = extra.X.col(j), M_x;
    for (int pass = 0; pass < 2; ++pass)
      x -= linalg::times(Q.leftCols(rank), problem.inner(MQ.leftCols(rank), x));
    problem.multiply_M(x, M_x);
    const double rest = std::sqrt(std::max(problem.inner(x, M_x)(0, 0), 0.0));
    // What carries little mass can still carry the load's strain energy: both must be covered.
    MatrixXd K_x;
    problem.multiply_K(x, K_x);
    const double energy = std::max(problem.inner(x, K_x)(0, 0), 0.0);
    if (!(rest > kDependent * std::sqrt(extra.mass(j))) &&
        !(energy > kDependent * kDependent * extra.energy(j))) {
      dropped.push_back(extra.names[static_cast<std::size_t>(j)]);
      continue;
    }
    Q.col(rank) = x / rest;
    MQ.col(rank++) = M_x / rest;
  }
  const Index fresh = rank - n_q;
  if (fresh == 0) return dropped;
  MatrixXd K_X;
  const MatrixXd X = Q.middleCols(n_q, fresh);
  problem.multiply_K(X, K_X);
  // One Rayleigh-Ritz step for all of them: what is mass-orthogonal to exact modes has no stiffness in common
  // with these, but the fresh shapes have with one another.
  const MatrixXd k = problem.inner(X, K_X);
  const linalg::DenseEigen ritz = linalg::symmetric_eigen(0.5 * (k + k.transpose()));
  pairs.Phi.conservativeResize(n, rank);
  pairs.Phi.rightCols(fresh) = linalg::times(X, ritz.vectors);
  pairs.omega2.conservativeResize(rank);
  pairs.omega2.tail(fresh) = ritz.values;
  return dropped;
}

}  // namespace flexura::reduce
