// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/ritz_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// n x k columns of +1 and -1: fixed ones (xorshift), so that equal input gives equal output.
MatrixXd signs(Index n, Index k) {
  MatrixXd Z(n, k);
  std::uint64_t bits = 0x9e3779b97f4a7c15u;
  for (Index c = 0; c < k; ++c)
    for (Index j = 0; j < n; ++j) {
      bits ^= bits << 13;
      bits ^= bits >> 7;
      bits ^= bits << 17;
      Z(j, c) = (bits >> 60 & 1) != 0 ? 1.0 : -1.0;
    }
  return Z;
}

// Entries of Omega^-1 Phi^T K Phi Omega^-1 - 1 are at most the residual asked of modes (1e-9) times the
// digits that orthogonality to the lowest of them loses; couplings that were left out had 1e-3 and more.
constexpr double kCoupling = 1e-6;
constexpr double kStatic = 1e-8;  // of the work that the exact answer does
constexpr Index kProbes = 4;

}  // namespace

void require_ritz(const linalg::EigenProblem& problem, const MatrixXd& Phi, const VectorXd& omega2,
                  const std::vector<StaticAnswer>& answers) {
  if (omega2.size() == 0) return;
  // Combinations in which every shape carries the same energy.
  const VectorXd omega = omega2.cwiseSqrt();
  const MatrixXd Z = omega.cwiseInverse().asDiagonal() * signs(omega.size(), kProbes);
  MatrixXd K_U;
  problem.multiply_K(linalg::times(Phi, Z), K_U);
  const MatrixXd force = problem.inner(Phi, K_U) - MatrixXd(omega2.asDiagonal() * Z);
  VectorXd apart = (omega.cwiseInverse().asDiagonal() * force).cwiseAbs().rowwise().maxCoeff();
  // What the products' own round-off can be: thin parts have stiffnesses beside which bending is little.
  MatrixXd K_size;
  // |Phi| by some columns at a time: a copy of thousands of modes is memory.
  constexpr Index kColumns = 256;
  MatrixXd size = MatrixXd::Zero(Phi.rows(), Z.cols());
  for (Index first = 0; first < Phi.cols(); first += kColumns) {
    const Index count = std::min(kColumns, Phi.cols() - first);
    size += linalg::times(Phi.middleCols(first, count).cwiseAbs(), Z.middleRows(first, count).cwiseAbs());
  }
  problem.multiply_magnitudes(size, K_size);
  MatrixXd energy(Phi.cols(), Z.cols());
  for (Index first = 0; first < Phi.cols(); first += kColumns) {
    const Index count = std::min(kColumns, Phi.cols() - first);
    energy.middleRows(first, count) = problem.inner(Phi.middleCols(first, count).cwiseAbs(), K_size);
  }
  const VectorXd round_off = 4.0 * std::numeric_limits<double>::epsilon() *
                             (omega.cwiseInverse().asDiagonal() * energy).rowwise().maxCoeff();
  apart = (apart - round_off).cwiseMax(0.0);
  Index worst = 0;
  const double most = apart.maxCoeff(&worst);
  if (!(most <= kCoupling * std::sqrt(static_cast<double>(omega.size()))))
    throw std::runtime_error(fmt::format(
        "shape {} ({:.5g} Hz): its stiffness in the superelement differs by {:.2g} of itself from the "
        "full model's, so frequencies could come out below the part's; ask for fewer response or "
        "load shapes",
        worst + 1, frequency_hz(omega2(worst)), most));
  for (const StaticAnswer& answer : answers) {
    const VectorXd participation = problem.inner(Phi, answer.f_i);
    const double work = participation.cwiseAbs2().cwiseQuotient(omega2).sum();
    if (std::abs(work - answer.work) <= kStatic * answer.work) continue;
    throw std::runtime_error(
        fmt::format("load \"{}\": its kept shape answers with {:.9g} J where the full model has {:.9g} J; it "
                    "depends too closely on the other shapes: leave out keep_shape at one of them",
                    answer.load, 0.5 * work, 0.5 * answer.work));
  }
}

void require_not_below(const VectorXd& omega2, const ReductionReport& report) {
  const auto below = (omega2.array() < report.certified_omega2).count();
  if (below <= report.certified_modes) return;
  throw std::runtime_error(fmt::format(
      "{} of the superelement's frequencies with held interfaces lie below {:.6g} Hz, by Sylvester's "
      "law the full model has {}: the reduced stiffness is too soft",
      below, frequency_hz(report.certified_omega2), report.certified_modes));
}

}  // namespace flexura::reduce
