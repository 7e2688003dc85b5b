// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/frequencies.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <complex>
#include <numeric>
#include <stdexcept>

namespace flexura::beam::ancf {

namespace {

using Eigen::MatrixXd;

MatrixXd dense(const Triplets& triplets, int rows, int cols) {
  MatrixXd out = MatrixXd::Zero(rows, cols);
  for (const auto& entry : triplets) out(entry.row(), entry.col()) += entry.value();
  return out;
}

// Columns span the motions that fixed coordinates and constraint rows allow.
MatrixXd allowed_motions(const Problem& problem, const MatrixXd& G) {
  const std::vector<char> free = problem.free_coordinates();
  const int n = static_cast<int>(free.size());
  const auto n_free = std::count(free.begin(), free.end(), 1);
  MatrixXd unit = MatrixXd::Zero(n, n_free);
  for (int i = 0, column = 0; i < n; ++i)
    if (free[i]) unit(i, column++) = 1.0;
  if (G.rows() == 0) return unit;
  const MatrixXd G_free = G * unit;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(G_free.transpose());
  const MatrixXd Q = qr.householderQ();
  return unit * Q.rightCols(Q.cols() - qr.rank());
}

}  // namespace

Vibrations vibrations(const Problem& problem, const Eigen::VectorXd& q, const Eigen::VectorXd& lambda,
                      double scale) {
  if (!(scale > 0.0))
    throw std::invalid_argument(
        fmt::format("the frequency scale is {:g} rad/s, but it must be positive.", scale));
  const int n_q = problem.body->n_q();
  ProblemScratch scratch(problem);
  Evaluation at;
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n_q);
  evaluate(problem, 1.0, q, &rest, lambda, scratch, at);
  const MatrixXd Z = allowed_motions(problem, dense(at.G, problem.n_lambda(), n_q));
  const MatrixXd M = Z.transpose() * (problem.body->mass().to_sparse() * Z);
  const MatrixXd K = Z.transpose() * dense(at.K, n_q, n_q) * Z;
  const MatrixXd D = Z.transpose() * dense(at.D, n_q, n_q) * Z;
  const int n = static_cast<int>(Z.cols());

  // With s = scale (1 + 1/mu):  mu^2 A_0 + mu A_1 + A_2 = 0, A_0 = K + scale D + scale^2 M, A_1 = scale D + 2
  // scale^2 M, A_2 = scale^2 M; the lowest |s| are among the largest |mu|, where the eigensolver is exact.
  const MatrixXd A_0 = K + scale * D + scale * scale * M;
  const Eigen::PartialPivLU<MatrixXd> lu(A_0);
  MatrixXd companion = MatrixXd::Zero(2 * n, 2 * n);
  companion.topRightCorner(n, n).setIdentity();
  companion.bottomLeftCorner(n, n) = -lu.solve(MatrixXd(scale * scale * M));
  companion.bottomRightCorner(n, n) = -lu.solve(MatrixXd(scale * D + 2 * scale * scale * M));
  if (!companion.allFinite())
    throw std::runtime_error("the shifted stiffness is singular; choose another frequency scale.");
  const Eigen::EigenSolver<MatrixXd> solver(companion);
  if (solver.info() != Eigen::Success)
    throw std::runtime_error("the eigenvalues of the vibrations did not converge.");

  const Eigen::VectorXcd mu = solver.eigenvalues();
  Eigen::VectorXcd s(2 * n);
  std::vector<int> order;
  for (int i = 0; i < 2 * n; ++i) {
    s[i] = scale * (1.0 + 1.0 / mu[i]);
    // mu and its conjugate are one vibration; the exactly real ones stay.
    if (s[i].imag() >= 0.0 && std::isfinite(s[i].real())) order.push_back(i);
  }
  std::sort(order.begin(), order.end(), [&](int a, int b) { return std::abs(s[a]) < std::abs(s[b]); });
  Vibrations out;
  out.s.resize(static_cast<int>(order.size()));
  out.modes.resize(n_q, static_cast<int>(order.size()));
  const Eigen::MatrixXcd vectors = solver.eigenvectors().topRows(n);
  for (std::size_t k = 0; k < order.size(); ++k) {
    out.s[k] = s[order[k]];
    Eigen::VectorXcd mode = Z * vectors.col(order[k]);
    Eigen::Index largest;
    mode.cwiseAbs().maxCoeff(&largest);
    out.modes.col(k) = mode / mode[largest];
  }
  return out;
}

}  // namespace flexura::beam::ancf
