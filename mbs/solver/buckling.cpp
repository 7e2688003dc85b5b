// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/buckling.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace flexura::mbs {

std::vector<BucklingMode> buckling_modes(const LinearSystem& unloaded, const LinearSystem& loaded) {
  if (unloaded.independent != loaded.independent)
    throw std::runtime_error(
        "the equilibrium under the loads lies too far from the unloaded mechanism for linear buckling: they "
        "take different coordinates; reduce the loads");
  const auto n = static_cast<Eigen::Index>(unloaded.independent.size());
  // A's lower left block is -M^-1 K.
  const Eigen::MatrixXd A_0 = unloaded.A.block(n, 0, n, n), A_1 = loaded.A.block(n, 0, n, n);
  if (n == 0)
    throw std::runtime_error(
        "nothing of the mechanism moves or deforms, so that nothing can buckle; let a body deform (fidelity "
        "= \"modal-stiffened\")");
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
  const double largest = solver.eigenvalues().cwiseAbs().maxCoeff();
  std::vector<BucklingMode> modes;
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::complex<double> mu = solver.eigenvalues()(i);
    if (std::abs(mu) <= 1e-8 * largest || std::abs(mu) == 0.0) continue;  // the loads do not reach it
    if (std::abs(mu.imag()) > 1e-6 * std::abs(mu)) continue;
    BucklingMode mode;
    mode.factor = 1.0 / mu.real();
    const Eigen::VectorXd z = scale.cwiseInverse().asDiagonal() * solver.eigenvectors().col(i).real();
    mode.shape = unloaded.N * z;
    Eigen::Index k = 0;
    if (mode.shape.cwiseAbs().maxCoeff(&k) > 0.0) mode.shape /= mode.shape(k);
    modes.push_back(std::move(mode));
  }
  std::sort(modes.begin(), modes.end(), [](const BucklingMode& a, const BucklingMode& b) {
    return std::abs(a.factor) < std::abs(b.factor);
  });
  return modes;
}

}  // namespace flexura::mbs
