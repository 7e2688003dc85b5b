// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/buckling.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace flexura::mbs {
namespace {

// A's lower left block is -M^-1 K; what the dynamic states c' = A_cz z + A_cc c are in equilibrium adds to it.
Eigen::MatrixXd static_stiffness(const LinearSystem& system) {
  const auto n = static_cast<Eigen::Index>(system.independent.size()), n_c = system.A.rows() - 2 * n;
  Eigen::MatrixXd K = system.A.block(n, 0, n, n);
  if (n_c == 0) return K;
  Eigen::MatrixXd A_cz = system.A.bottomLeftCorner(n_c, n), A_cc = system.A.bottomRightCorner(n_c, n_c);
  for (Eigen::Index i = 0; i < n_c; ++i) {
    const double size = A_cc.row(i).cwiseAbs().maxCoeff();
    if (!(size > 0.0))
      throw std::runtime_error(fmt::format(
          "the dynamic state \"{}\" has no static value: it integrates, so that nothing can be said of "
          "buckling; hold it constant",
          system.states[static_cast<std::size_t>(2 * n + i)]));
    A_cc.row(i) /= size;
    A_cz.row(i) /= size;
  }
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(A_cc);
  // Differences leave 1e-9 of A's scale.
  if (!(lu.rcond() > 1e-9))
    throw std::runtime_error(
        "the dynamic states of controls and actuators have no static values, so that nothing can be said of "
        "buckling; hold them constant");
  K -= system.A.block(n, 2 * n, n, n_c) * lu.solve(A_cz);
  return K;
}

}  // namespace

Buckling buckling_modes(const LinearSystem& unloaded, const LinearSystem& loaded) {
  if (unloaded.independent != loaded.independent)
    throw std::runtime_error(
        "the equilibrium under the loads lies too far from the unloaded mechanism for linear buckling: they "
        "take different coordinates; reduce the loads");
  const auto n = static_cast<Eigen::Index>(unloaded.independent.size());
  if (n == 0) return {};
  const Eigen::MatrixXd A_0 = static_stiffness(unloaded), A_1 = static_stiffness(loaded);
  const Eigen::VectorXd scale = A_0.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(scale.cwiseInverse().asDiagonal() * A_0 *
                                             scale.cwiseInverse().asDiagonal());
  // Differences leave 1e-9 of A's scale: what lies below is no stiffness.
  if (!(lu.rcond() > 1e-11))
    throw std::runtime_error(
        "the mechanism moves without stiffness when its loads are taken away, so that nothing can buckle; "
        "hold it by joints or springs");
  const Eigen::MatrixXd B =
      lu.solve(scale.cwiseInverse().asDiagonal() * (A_0 - A_1) * scale.cwiseInverse().asDiagonal());
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(B);
  const double change = B.cwiseAbs().maxCoeff();
  Buckling out;
  std::vector<BucklingMode>& modes = out.modes;
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::complex<double> mu = solver.eigenvalues()(i);
    // The loads do not reach it: 1e-8 of the stiffness is the noise of the differences, and its square root
    // what becomes of two zeros of loads that follow the motion.
    if (std::abs(mu) <= std::max(1e-8, 1e-4 * change)) continue;
    // Two equal factors are found as a pair apart by the square root of that noise.
    if (std::abs(mu.imag()) > 1e-4 * std::abs(mu)) {
      out.has_complex_factors = true;
      continue;
    }
    BucklingMode mode;
    mode.factor = 1.0 / mu.real();
    const Eigen::VectorXd z = scale.cwiseInverse().asDiagonal() * solver.eigenvectors().col(i).real();
    mode.shape = unloaded.N * z;
    Eigen::Index k = 0;
    if (mode.shape.cwiseAbs().maxCoeff(&k) > 0.0) mode.shape /= mode.shape(k);
    modes.push_back(std::move(mode));
  }
  // Of loads with a potential some factor is real.
  if (modes.empty() && change > 1e-7) out.has_complex_factors = true;
  std::sort(modes.begin(), modes.end(), [](const BucklingMode& a, const BucklingMode& b) {
    return std::abs(a.factor) < std::abs(b.factor);
  });
  return out;
}

}  // namespace flexura::mbs
