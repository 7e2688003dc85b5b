// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/cholesky.hpp"

#include <cholmod.h>

#include <algorithm>
#include <string>
#include <vector>

#include "reduce/linalg/progress.hpp"
#include "reduce/linalg/supernodal_solve.hpp"

namespace flexura::linalg {
namespace {

// A pivot L_jj^2 below this fraction of A_jj is round-off of a zero: the last pivots of a slender body are
// its static stiffness over the local one, (diameter / length)^3 times a few powers of ten, far above.
constexpr double kSmallestPivot = 1e-13;

cholmod_sparse view_of(const UpperCsr& A) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(A.n);
  view.nzmax = A.columns.size();
  view.p = const_cast<int*>(A.row_begin.data());
  view.i = const_cast<int*>(A.columns.data());
  view.x = const_cast<double*>(A.values.data());
  view.stype = -1;  // upper triangle by rows = lower triangle by columns
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

}  // namespace

struct CholeskyFactor::Impl {
  cholmod_common common{};
  cholmod_factor* L = nullptr;
  int n = 0;
  FactorFigures figures;

  Impl() {
    cholmod_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = 1;
  }
  ~Impl() {
    cholmod_free_factor(&L, &common);
    cholmod_finish(&common);
  }

  void check(const char* doing) const {
    if (common.status == CHOLMOD_OUT_OF_MEMORY)
      throw std::runtime_error(std::string("memory does not suffice while ") + doing +
                               ": use a coarser mesh or a machine with more memory");
    if (common.status == CHOLMOD_TOO_LARGE)
      throw std::runtime_error(std::string("the matrix is too large for 32-bit indices while ") + doing +
                               ": use a coarser mesh");
    if (common.status < 0)
      throw std::runtime_error(std::string("CHOLMOD failed while ") + doing + " (status " +
                               std::to_string(common.status) + ")");
  }

  std::vector<int> order(const UpperCsr& A, std::span<const int> group_begin);
  SupernodalFactor supernodes() const;
  void check_pivots(const UpperCsr& A);
};

// Nested dissection of the graph of groups, expanded to rows.
std::vector<int> CholeskyFactor::Impl::order(const UpperCsr& A, std::span<const int> group_begin) {
  std::vector<int> singles;
  if (group_begin.empty()) {
    singles.resize(A.n + 1);
    for (int i = 0; i <= A.n; ++i) singles[i] = i;
    group_begin = singles;
  }
  const int n_groups = static_cast<int>(group_begin.size()) - 1;
  std::vector<int> group_of(A.n), begin{0}, columns;
  for (int g = 0; g < n_groups; ++g)
    for (int i = group_begin[g]; i < group_begin[g + 1]; ++i) group_of[i] = g;
  for (int g = 0; g < n_groups; ++g) {
    const int i = group_begin[g];  // the first row of a group has the longest upper pattern
    int last = -1;
    if (group_begin[g] < group_begin[g + 1])
      for (int k = A.row_begin[i]; k < A.row_begin[i + 1]; ++k)
        if (group_of[A.columns[k]] != last) columns.push_back(last = group_of[A.columns[k]]);
    begin.push_back(static_cast<int>(columns.size()));
  }
  cholmod_sparse graph = view_of({n_groups, begin, columns, {}});
  graph.x = nullptr;
  graph.xtype = CHOLMOD_PATTERN;
  std::vector<int> group_order(n_groups), rows;
  cholmod_metis(&graph, nullptr, 0, 1, group_order.data(), &common);
  check("ordering the matrix");
  rows.reserve(A.n);
  for (int g : group_order)
    for (int i = group_begin[g]; i < group_begin[g + 1]; ++i) rows.push_back(i);
  return rows;
}

SupernodalFactor CholeskyFactor::Impl::supernodes() const {
  const auto ints = [](const void* array) { return static_cast<const int*>(array); };
  return {n,          static_cast<int>(L->nsuper),      ints(L->super), ints(L->pi), ints(L->px),
          ints(L->s), static_cast<const double*>(L->x), ints(L->Perm)};
}

// Looks at the diagonal of the supernodal factor for pivots that are round-off.
void CholeskyFactor::Impl::check_pivots(const UpperCsr& A) {
  const SupernodalFactor f = supernodes();
  double smallest = 1.0;
  int where = 0;
  for (int s = 0; s < f.n_supernodes; ++s) {
    const std::ptrdiff_t n_rows = f.first_row[s + 1] - f.first_row[s];
    for (int c = 0; c < f.first_column[s + 1] - f.first_column[s]; ++c) {
      const double l = f.values[f.first_value[s] + c * n_rows + c];
      const int row = f.permutation[f.first_column[s] + c];
      const double pivot = l * l / A.values[A.row_begin[row]];
      if (!(pivot >= smallest)) smallest = pivot, where = row;
    }
  }
  figures.smallest_pivot = smallest;
  if (!(smallest > kSmallestPivot)) throw SingularMatrix(where, "the matrix is singular to round-off");
}

CholeskyFactor::CholeskyFactor(const SymmetricMatrix& A, std::span<const int> group_begin,
                               std::span<const int> doubled)
    : impl_(std::make_unique<Impl>()) {
  const UpperCsr csr = A.csr();
  impl_->n = csr.n;
  if (csr.n == 0) return;
  Stopwatch watch;
  std::vector<int> permutation = impl_->order(csr, group_begin);
  impl_->figures.seconds_ordering = watch.lap();
  cholmod_sparse view = view_of(csr);
  impl_->L = cholmod_analyze_p(&view, permutation.data(), nullptr, 0, &impl_->common);
  impl_->check("analysing the matrix");
  impl_->figures.seconds_symbolic = watch.lap();
  {
    // The matrix is left as it was: only the factor sees the doubled entries.
    std::vector<double> values;
    if (!doubled.empty()) {
      values.assign(csr.values.begin(), csr.values.end());
      for (int row : doubled) values[csr.row_begin[row]] *= 2.0;
      view.x = values.data();
    }
    cholmod_factorize(&view, impl_->L, &impl_->common);
  }
  impl_->check("factorising the matrix");
  impl_->figures.seconds_numeric = watch.lap();
  impl_->figures.nonzeros = impl_->common.lnz;
  impl_->figures.flops = impl_->common.fl;
  if (impl_->common.status == CHOLMOD_NOT_POSDEF) {
    const int column = static_cast<int>(std::min<std::size_t>(impl_->L->minor, csr.n - 1));
    throw SingularMatrix(static_cast<const int*>(impl_->L->Perm)[column],
                         "the matrix is not positive definite");
  }
  impl_->check_pivots(csr);
}

CholeskyFactor::~CholeskyFactor() = default;
CholeskyFactor::CholeskyFactor(CholeskyFactor&&) noexcept = default;
CholeskyFactor& CholeskyFactor::operator=(CholeskyFactor&&) noexcept = default;

Eigen::MatrixXd CholeskyFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const {
  if (B.rows() != impl_->n)
    throw std::logic_error("solve: the right-hand sides do not have the matrix's length");
  Eigen::MatrixXd X(B.rows(), B.cols());
  if (X.size() > 0) supernodal_solve(impl_->supernodes(), B, X);
  return X;
}

int CholeskyFactor::size() const {
  return impl_->n;
}
const FactorFigures& CholeskyFactor::figures() const {
  return impl_->figures;
}

}  // namespace flexura::linalg
