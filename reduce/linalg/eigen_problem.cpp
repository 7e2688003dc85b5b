// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen_problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace flexura::linalg {

namespace {
// Round-off adds up at random and stays below the bound (0.4 to 0.7 of it on slender and on coarse parts);
// the factors of K bring a few times that.
constexpr double kAboveRoundOff = 4.0;
}  // namespace

void trim(EigenPairs& pairs, const EigenRequest& request) {
  Eigen::Index keep = std::min<Eigen::Index>(request.count, pairs.omega2.size());
  while (keep < pairs.omega2.size() && pairs.omega2(keep) <= request.omega2_max) ++keep;
  while (keep > 0 && keep < pairs.omega2.size() &&
         pairs.omega2(keep) - pairs.omega2(keep - 1) < kClusterGap * std::abs(pairs.omega2(keep)))
    ++keep;
  pairs.omega2_next =
      keep < pairs.omega2.size() ? pairs.omega2(keep) : std::numeric_limits<double>::infinity();
  pairs.omega2.conservativeResize(keep);
  pairs.Phi.conservativeResize(Eigen::NoChange, keep);
}

bool is_accurate(const EigenPairs& pairs, double tolerance) {
  return (pairs.residual.array() <= (kAboveRoundOff * pairs.round_off.array()).max(tolerance)).all();
}

void measure_residuals(const EigenProblem& problem, EigenPairs& pairs) {
  const Eigen::Index count = pairs.Phi.cols();
  pairs.omega2.resize(count);
  pairs.residual.resize(count);
  pairs.round_off.resize(count);
  constexpr Eigen::Index kWidth = 16;  // columns at a time, to bound the memory
  for (Eigen::Index first = 0; first < count; first += kWidth) {
    const Eigen::Index width = std::min(kWidth, count - first);
    Eigen::MatrixXd K_phi, M_phi, magnitudes;
    problem.multiply_K(pairs.Phi.middleCols(first, width), K_phi);
    problem.multiply_M(pairs.Phi.middleCols(first, width), M_phi);
    problem.multiply_magnitudes(pairs.Phi.middleCols(first, width), magnitudes);
    Eigen::MatrixXd residual = K_phi;
    Eigen::MatrixXd scale = K_phi + problem.shift * M_phi;
    for (Eigen::Index c = 0; c < width; ++c) {
      const auto phi = pairs.Phi.col(first + c);
      pairs.omega2(first + c) = phi.dot(K_phi.col(c)) / phi.dot(M_phi.col(c));
      residual.col(c) -= pairs.omega2(first + c) * M_phi.col(c);
    }
    problem.project_residual(residual);
    problem.project_residual(scale);
    for (Eigen::Index c = 0; c < width; ++c) {
      pairs.residual(first + c) = residual.col(c).norm() / scale.col(c).norm();
      pairs.round_off(first + c) =
          std::numeric_limits<double>::epsilon() * magnitudes.col(c).norm() / scale.col(c).norm();
    }
  }
}

}  // namespace flexura::linalg
