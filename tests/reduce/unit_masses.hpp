// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"
#include "reduce/linalg/factor/cholesky.hpp"

namespace flexura::linalg::testing {

/// A x = omega^2 x for a positive definite A and its factor, which must outlive it.
inline EigenProblem unit_mass_problem(const SymmetricMatrix& A, const CholeskyFactor& factor) {
  EigenProblem problem;
  problem.n = problem.n_free = A.size();
  problem.solve = [&factor](const auto& X, auto& Y) { Y = factor.solve(X); };
  problem.multiply_K = [&A](const auto& X, auto& Y) { A.multiply(X, Y); };
  problem.multiply_magnitudes = [&A](const auto& X, auto& Y) { A.multiply_magnitudes(X, Y); };
  problem.multiply_M = [](const auto& X, auto& Y) { Y = X; };
  return problem;
}

}  // namespace flexura::linalg::testing
