// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/dense_pairs.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::linalg {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

bool may_be_dense(const EigenProblem& problem) {
  constexpr int kMost = 3000;  // 70 MB a matrix, half a minute
  return !problem.sum && problem.n_free > 0 && problem.n_free <= kMost;
}

bool is_dense(const EigenProblem& problem, const EigenRequest& request) {
  constexpr int kFew = 100;
  return may_be_dense(problem) && (problem.n_free <= kFew || 3 * request.count >= problem.n_free);
}

namespace {

// An orthonormal basis of the problem's space.
MatrixXd basis_of(const EigenProblem& problem) {
  MatrixXd Q = MatrixXd::Identity(problem.n, problem.n);
  if (problem.n_free == problem.n) return Q;
  if (problem.project)
    problem.project(Q);
  else
    problem.solve(MatrixXd::Identity(problem.n, problem.n), Q);
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(Q);
  return qr.householderQ() * MatrixXd::Identity(problem.n, problem.n_free);
}

MatrixXd projected(const MatrixXd& Q, const EigenProblem::Operator& multiply) {
  MatrixXd AQ;
  multiply(Q, AQ);
  const MatrixXd A = transpose_times(Q, AQ);
  return 0.5 * (A + A.transpose());
}

// With the shift sigma, to the accuracy that can be had.
EigenPairs shifted_pairs(const EigenProblem& problem, const EigenRequest& request, const MatrixXd& Q,
                         const MatrixXd& K, const MatrixXd& M, double sigma) {
  MatrixXd A = K + sigma * M;
  const VectorXd s = A.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
  A = (s.asDiagonal() * A * s.asDiagonal()).eval();
  const DenseEigen dense = generalized_eigen(s.asDiagonal() * M * s.asDiagonal(), A);
  // mu = 1 / (omega^2 + sigma), ascending; what has no mass has no frequency.
  const Index n = dense.values.size();
  Index n_modes = 0;
  while (n_modes < n && dense.values(n - 1 - n_modes) > static_cast<double>(n) *
                                                            std::numeric_limits<double>::epsilon() *
                                                            dense.values(n - 1))
    ++n_modes;
  EigenPairs pairs;
  pairs.omega2.resize(n_modes);
  for (Index k = 0; k < n_modes; ++k) pairs.omega2(k) = 1.0 / dense.values(n - 1 - k) - sigma;
  pairs.Phi = Q * (s.asDiagonal() * dense.vectors.rightCols(n_modes).rowwise().reverse());
  trim(pairs, request);
  if (pairs.Phi.cols() > 0) {
    for (Index k = 0; k < pairs.Phi.cols(); ++k)
      pairs.Phi.col(k) *= std::sqrt(pairs.omega2(k) + sigma);  // phi^T (K + sigma M) phi = 1 so far
    orthonormalise(problem, pairs.Phi);
  }
  measure_residuals(problem, pairs);
  if (pairs.Phi.cols() > 0) polish_until_accurate(problem, request.tolerance, pairs);
  return pairs;
}

}  // namespace

EigenPairs dense_pairs(const EigenProblem& problem, const EigenRequest& request) {
  const MatrixXd Q = basis_of(problem);
  const MatrixXd K = projected(Q, problem.multiply_K), M = projected(Q, problem.multiply_M);
  double logarithms = 0.0, least = std::numeric_limits<double>::infinity();
  int count = 0;
  for (Index i = 0; i < K.rows(); ++i)
    if (M(i, i) > 0.0 && K(i, i) > 0.0) {
      logarithms += std::log(K(i, i) / M(i, i));
      least = std::min(least, K(i, i) / M(i, i));
      ++count;
    }
  // In the middle of the frequencies both ends are as exact; where a light shaft carries a heavy disc, whose modes lie far below, near
  // the lowest.
  EigenPairs pairs = shifted_pairs(problem, request, Q, K, M, count > 0 ? std::exp(logarithms / count) : 1.0);
  if (count > 0 && !is_accurate(pairs, request.tolerance)) {
    EigenPairs low = shifted_pairs(problem, request, Q, K, M, least);
    if (low.Phi.cols() == pairs.Phi.cols() && is_accurate(low, request.tolerance)) pairs = std::move(low);
  }
  if (pairs.Phi.cols() > 0 && !is_accurate(pairs, request.tolerance))
    throw std::runtime_error(fmt::format(
        "the worst residual of {} modes stays at {:.1e}, above {:.1e}: the stiffness matrix is too "
        "badly conditioned for this accuracy",
        pairs.Phi.cols(), pairs.residual.maxCoeff(), request.tolerance));
  return pairs;
}

}  // namespace flexura::linalg
