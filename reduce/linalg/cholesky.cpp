// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/cholesky.hpp"

#include <algorithm>
#include <vector>

#include "reduce/linalg/progress.hpp"
#include "reduce/linalg/supernodal_factor.hpp"

namespace flexura::linalg {
namespace {

// A pivot L_jj^2 below this fraction of A_jj is round-off of a zero: the last pivots of a slender body are
// its static stiffness over the local one, (diameter / length)^3 times a few powers of ten, far above.
constexpr double kSmallestPivot = 1e-13;

}  // namespace

struct CholeskyFactor::Impl {
  SupernodalFactor L;
  FactorFigures figures;
};

CholeskyFactor::CholeskyFactor(const SymmetricMatrix& A, std::span<const int> group_begin,
                               std::span<const int> doubled, const FactorStorage& storage) {
  UpperCsr csr = A.csr();
  Stopwatch watch;
  std::vector<int> order;
  if (csr.n > 0) order = nested_dissection(csr, group_begin);
  const double seconds_ordering = watch.lap();
  impl_ = std::make_unique<Impl>(Impl{SupernodalFactor(csr, std::move(order)), {}});
  FactorFigures& figures = impl_->figures;
  figures.seconds_ordering = seconds_ordering;
  figures.seconds_symbolic = watch.lap();
  figures.nonzeros = impl_->L.nonzeros();
  figures.flops = impl_->L.flops();
  figures.bytes = impl_->L.bytes();
  // The matrix is left as it was: only the factor sees the doubled entries.
  std::vector<double> values;
  if (!doubled.empty()) {
    values.assign(csr.values.begin(), csr.values.end());
    for (const int row : doubled) values[csr.row_begin[row]] *= 2.0;
    csr.values = values;
  }
  const double before = processor_seconds();
  const int failed = impl_->L.factorise(csr, true, storage);
  if (failed >= 0) throw SingularMatrix(failed, "the matrix is not positive definite");
  figures.seconds_numeric = watch.lap();
  figures.processor_seconds = processor_seconds() - before;
  figures.in_file = impl_->L.is_in_file();
  const SupernodalFactor::Pivot smallest = impl_->L.smallest_pivot(A.csr());
  figures.smallest_pivot = smallest.ratio;
  if (!(smallest.ratio > kSmallestPivot))
    throw SingularMatrix(smallest.row, "the matrix is singular to round-off");
}

CholeskyFactor::~CholeskyFactor() = default;
CholeskyFactor::CholeskyFactor(CholeskyFactor&&) noexcept = default;
CholeskyFactor& CholeskyFactor::operator=(CholeskyFactor&&) noexcept = default;

Eigen::MatrixXd CholeskyFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  if (B.rows() != impl_->L.size())
    throw std::logic_error("solve: the right-hand sides do not have the matrix's length");
  Eigen::MatrixXd X(B.rows(), B.cols());
  if (X.size() > 0) impl_->L.solve(B, X);
  return X;
}

int CholeskyFactor::size() const {
  return impl_->L.size();
}
const std::vector<int>& CholeskyFactor::order() const {
  return impl_->L.order();
}
const FactorFigures& CholeskyFactor::figures() const {
  return impl_->figures;
}

}  // namespace flexura::linalg
