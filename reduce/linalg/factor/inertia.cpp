// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/inertia.hpp"

#include <stdexcept>

#include "reduce/linalg/factor/direct_solver.hpp"

namespace flexura::linalg {

struct IndefiniteFactor::Impl {
  DirectSolver solver;
};

IndefiniteFactor::IndefiniteFactor(const SymmetricMatrix& A, std::vector<int> order,
                                   const FactorStorage& storage)
    : impl_(new Impl{DirectSolver(A, {.definite = false,
                                      .count_negative = true,
                                      .hints = {.order = std::move(order), .storage = storage}})}) {
  if (impl_->solver.failure().failed)
    throw std::runtime_error(
        "counting eigenvalues: the limit is too close to an eigenvalue of the structure or of a piece of it; "
        "move it a little");
}

IndefiniteFactor::~IndefiniteFactor() = default;
IndefiniteFactor::IndefiniteFactor(IndefiniteFactor&&) noexcept = default;
IndefiniteFactor& IndefiniteFactor::operator=(IndefiniteFactor&&) noexcept = default;

int IndefiniteFactor::n_negative() const {
  return impl_->solver.n_negative();
}

const FactorFigures& IndefiniteFactor::figures() const {
  return impl_->solver.figures();
}

Eigen::MatrixXd IndefiniteFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  Eigen::MatrixXd X(B.rows(), B.cols());
  impl_->solver.solve(B, X);
  return X;
}

}  // namespace flexura::linalg
