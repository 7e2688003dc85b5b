// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/cholesky.hpp"

#include <optional>

#include "reduce/linalg/factor/direct_solver.hpp"

namespace flexura::linalg {

struct CholeskyFactor::Impl {
  std::optional<DirectSolver> solver;  // of no rows: none
  std::vector<int> no_order;
  FactorFigures no_figures;
};

CholeskyFactor::CholeskyFactor(const SymmetricMatrix& A, std::span<const int> group_begin,
                               std::span<const int> doubled, const FactorStorage& storage)
    : impl_(new Impl) {
  if (A.size() == 0) return;
  impl_->solver.emplace(
      A, DirectSolver::Settings{
             .group_begin = group_begin, .doubled = doubled, .hints = {.order = {}, .storage = storage}});
  if (const DirectSolver::Failure& failure = impl_->solver->failure(); failure.failed)
    throw SingularMatrix(failure.row, "the matrix is not positive definite to round-off");
}

CholeskyFactor::~CholeskyFactor() = default;
CholeskyFactor::CholeskyFactor(CholeskyFactor&&) noexcept = default;
CholeskyFactor& CholeskyFactor::operator=(CholeskyFactor&&) noexcept = default;

Eigen::MatrixXd CholeskyFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  Eigen::MatrixXd X(B.rows(), B.cols());
  if (impl_->solver) impl_->solver->solve(B, X);
  return X;
}

void CholeskyFactor::view(_p_PetscViewer* viewer) const {
  if (impl_->solver) impl_->solver->view(viewer);
}

int CholeskyFactor::size() const {
  return impl_->solver ? impl_->solver->size() : 0;
}
const std::vector<int>& CholeskyFactor::order() const {
  return impl_->solver ? impl_->solver->order() : impl_->no_order;
}
const FactorFigures& CholeskyFactor::figures() const {
  return impl_->solver ? impl_->solver->figures() : impl_->no_figures;
}

}  // namespace flexura::linalg
