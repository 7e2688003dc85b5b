// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/refinement.hpp"

#include <algorithm>
#include <limits>
#include <random>

#include "reduce/linalg/dense/random_numbers.hpp"

namespace flexura::linalg {

bool stands_the_test(const SupernodalFactor& L, const UpperCsr& A) {
  constexpr double kResidual = 0.1;
  std::mt19937_64 random(19781105);
  Eigen::MatrixXd R = random_numbers(A.n, 8, random), D, AD;
  double before = std::numeric_limits<double>::infinity();  // the first solve may leave more than there was
  for (int solves = L.is_single() ? 8 : 1; solves > 0; --solves) {
    L.solve(R, D);
    multiply(A, D, AD);
    R -= AD;
    const double residual = R.colwise().norm().maxCoeff();
    if (residual < kResidual) return true;
    if (!(residual < 0.5 * before)) return false;
    before = residual;
  }
  return false;
}

void refine(const SupernodalFactor& L, const UpperCsr& A, const Eigen::Ref<const Eigen::MatrixXd>& B,
            Eigen::Ref<Eigen::MatrixXd> X) {
  constexpr double kRoundOff = 1e-15;
  Eigen::MatrixXd R, AX;
  double before = 1.0;  // the greatest correction, relative to X
  for (int k = 0; k < 20; ++k) {
    multiply(A, X, AX);
    R = B - AX;
    L.solve_into(R, R);
    double correction = 0.0;
    for (Eigen::Index c = 0; c < X.cols(); ++c)
      if (const double size = X.col(c).norm(); size > 0.0)
        correction = std::max(correction, R.col(c).norm() / size);
    if (!(correction < before)) return;
    X += R;
    if (correction * correction / before < kRoundOff) return;
    before = correction;
  }
}

}  // namespace flexura::linalg
