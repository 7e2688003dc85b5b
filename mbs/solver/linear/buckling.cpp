// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/buckling.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace flexura::mbs {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Throws where the softest direction of the scaled K is no stiffer than its noise.
void require_stiff(const StaticStiffness& unloaded, const MatrixXd& K, const MatrixXd& E) {
  const Eigen::BDCSVD<MatrixXd> svd(K, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Index last = K.rows() - 1;
  const VectorXd u = svd.matrixU().col(last), v = svd.matrixV().col(last);
  if (svd.singularValues()(last) > kBeyondNoise * noise_of(u, E, v)) return;
  Index k = 0;
  v.cwiseAbs().maxCoeff(&k);
  throw std::runtime_error(
      fmt::format("the mechanism moves without stiffness when its loads are taken away, most in \"{}\", so "
                  "that nothing can "
                  "buckle; hold it by joints or springs (a stiffness beside others 1e13 times larger is not "
                  "told from none)",
                  unloaded.names[static_cast<std::size_t>(k)]));
}

}  // namespace

Buckling buckling_modes(const StaticStiffness& unloaded, const StaticStiffness& loaded) {
  if (unloaded.independent != loaded.independent)
    throw std::runtime_error(
        "the equilibrium under the loads lies too far from the unloaded mechanism for linear buckling: they "
        "take different coordinates; reduce the loads");
  const Index n = unloaded.K.rows();
  if (n == 0) return {};
  // Every coordinate as stiff as the others.
  VectorXd unit(n);
  for (Index i = 0; i < n; ++i) {
    const double k = std::abs(unloaded.K(i, i));
    unit(i) = k > 0.0 ? 1.0 / std::sqrt(k) : 1.0;
  }
  const auto scaled = [&](const MatrixXd& X) -> MatrixXd {
    return unit.asDiagonal() * X * unit.asDiagonal();
  };
  MatrixXd K_0 = scaled(unloaded.K);
  const MatrixXd E_0 = scaled(unloaded.error), E_1 = scaled(loaded.error), change = K_0 - scaled(loaded.K);
  require_stiff(unloaded, K_0, E_0);
  // C = A^-1 change B^-1, A B = K_0: symmetric where both are, so that its eigenvalues are as exact as they can be.
  MatrixXd C, left, right;  // rows of `left` and columns of `right`: A^-1 and B^-1 themselves
  const Eigen::LLT<MatrixXd> cholesky(0.5 * (K_0 + K_0.transpose()));
  const bool is_symmetric = ((K_0 - K_0.transpose()).cwiseAbs() - 10.0 * E_0).maxCoeff() <= 0.0 &&
                            cholesky.info() == Eigen::Success;
  if (is_symmetric) {
    left = cholesky.matrixL().solve(MatrixXd::Identity(n, n));
    right = left.transpose();
  } else {
    left = K_0.fullPivLu().inverse();
    right = MatrixXd::Identity(n, n);
  }
  C = left * change * right;
  Eigen::VectorXcd mus;
  Eigen::MatrixXcd X, W;
  if (is_symmetric && ((change - change.transpose()).cwiseAbs() - 10.0 * (E_0 + E_1)).maxCoeff() <= 0.0) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(0.5 * (C + C.transpose()));
    mus = solver.eigenvalues().cast<std::complex<double>>();
    X = solver.eigenvectors().cast<std::complex<double>>();
    W = X.transpose();
  } else {
    const Eigen::EigenSolver<MatrixXd> solver(C);
    mus = solver.eigenvalues();
    X = solver.eigenvectors();
    W = X.fullPivLu().inverse();
  }
  Buckling out;
  std::vector<BucklingMode>& modes = out.modes;
  double unseen = 0.0;
  for (Index i = 0; i < n; ++i) {
    const std::complex<double> mu = mus(i);
    const VectorXd l = (W.row(i) * left).cwiseAbs().transpose(), x = (right * X.col(i)).cwiseAbs();
    const double noise =
        kBeyondNoise * std::hypot((1.0 + std::abs(mu)) * noise_of(l, E_0, x), noise_of(l, E_1, x)) +
        1e-15 * C.norm() * W.row(i).norm() * X.col(i).norm();
    // The loads do not reach it, or two zeros of loads that follow the motion are found apart.
    if (!(std::abs(mu) > noise)) {
      unseen = std::max(unseen, std::abs(mu) + noise);
      continue;
    }
    // So are two equal factors.
    if (std::abs(mu.imag()) > noise) {
      out.has_complex_factors = true;
      continue;
    }
    BucklingMode mode;
    mode.factor = 1.0 / mu.real();
    mode.error = noise / std::abs(mu);
    const VectorXd z = unit.asDiagonal() * (right * X.col(i).real());
    mode.shape = unloaded.N * z;
    Index k = 0;
    if (mode.shape.cwiseAbs().maxCoeff(&k) > 0.0) mode.shape /= mode.shape(k);
    modes.push_back(std::move(mode));
  }
  if (unseen > 0.0) out.seen_to = 1.0 / unseen;
  // Of loads with a potential some factor is real.
  if (modes.empty() && (change.cwiseAbs() - 10.0 * (E_0 + E_1)).maxCoeff() > 0.0)
    out.has_complex_factors = true;
  std::sort(modes.begin(), modes.end(), [](const BucklingMode& a, const BucklingMode& b) {
    return std::abs(a.factor) < std::abs(b.factor);
  });
  return out;
}

}  // namespace flexura::mbs
