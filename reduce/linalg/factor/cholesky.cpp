// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/cholesky.hpp"

#include "reduce/linalg/factor/direct_solver.hpp"

namespace flexura::linalg {

struct CholeskyFactor::Impl {
  DirectSolver solver;
};

CholeskyFactor::CholeskyFactor(const SymmetricMatrix& A, std::span<const int> group_begin,
                               std::span<const int> doubled, const FactorStorage& storage)
    : impl_(new Impl{DirectSolver(
          A, {.group_begin = group_begin, .doubled = doubled, .hints = {.order = {}, .storage = storage}})}) {
  if (const DirectSolver::Failure& failure = impl_->solver.failure(); failure.failed)
    throw SingularMatrix(failure.row, "the matrix is not positive definite to round-off");
}

CholeskyFactor::~CholeskyFactor() = default;
CholeskyFactor::CholeskyFactor(CholeskyFactor&&) noexcept = default;
CholeskyFactor& CholeskyFactor::operator=(CholeskyFactor&&) noexcept = default;

Eigen::MatrixXd CholeskyFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  Eigen::MatrixXd X(B.rows(), B.cols());
  impl_->solver.solve(B, X);
  return X;
}

void CholeskyFactor::view(_p_PetscViewer* viewer) const {
  impl_->solver.view(viewer);
}

int CholeskyFactor::size() const {
  return impl_->solver.size();
}
const std::vector<int>& CholeskyFactor::order() const {
  return impl_->solver.order();
}
const FactorFigures& CholeskyFactor::figures() const {
  return impl_->solver.figures();
}

}  // namespace flexura::linalg
