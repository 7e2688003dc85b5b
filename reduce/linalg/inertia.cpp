// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/inertia.hpp"

#include <random>
#include <stdexcept>

namespace flexura::linalg {
namespace {

SupernodalFactor analysed(const UpperCsr& A, std::vector<int> order) {
  if (order.empty() && A.n > 0) order = nested_dissection(A);
  return {A, std::move(order)};
}

}  // namespace

IndefiniteFactor::IndefiniteFactor(const SymmetricMatrix& A, std::vector<int> order,
                                   const FactorStorage& storage)
    : factor_(analysed(A.csr(), std::move(order))) {
  const bool failed = factor_.factorise(A.csr(), false, storage) >= 0;
  // Round-off E that takes an eigenvalue mu of A past zero is greater than mu, and greater than mu + e, what
  // the factor has in its place.  So the residual E x of x = (A + E)^-1 b is no smaller than b's part along
  // the eigenvector, which is normally distributed: in one of eight draws it is above 0.1, but for once in
  // 1e9.
  constexpr double kResidual = 0.1;
  Eigen::MatrixXd B(A.size(), 8), AX;
  std::mt19937_64 random(19781105);
  std::normal_distribution<double> normal;
  for (double& b : B.reshaped()) b = normal(random);
  if (!failed) A.multiply(solve(B), AX);
  if (failed || !((AX - B).colwise().norm().maxCoeff() < kResidual))
    throw std::runtime_error(
        "counting eigenvalues: the limit is too close to an eigenvalue of the structure or of a piece of it; "
        "move it a little");
}

Eigen::MatrixXd IndefiniteFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  Eigen::MatrixXd X;
  factor_.solve(B, X);
  return X;
}

}  // namespace flexura::linalg
