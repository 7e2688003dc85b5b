// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/dense/symmetric_matrix.hpp"

#include <petscmat.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "mbs/base/math/simd.hpp"
#include "reduce/linalg/dense/column_panels.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

// y += A x for rows first ... last of A and their mirror images, W interleaved columns of `Directions` interleaved directions:
// row 3 i + a of column c is at place (i, a, c), so that what one entry of A multiplies lies together.  y_begins: the row
// that y begins with.
template <int W, int Directions>
FLEXURA_INLINE void add_rows(const UpperCsr& A, int first, int last, const double* x_values, double* y_values,
                             std::ptrdiff_t y_begins = 0) {
  using Row = typename Lanes<W>::Row;
  const Row* x = reinterpret_cast<const Row*>(x_values);
  Row* y = reinterpret_cast<Row*>(y_values);
  for (int i = first; i < last; ++i) {
    const int begin = A.row_begin[i], end = A.row_begin[i + 1];
    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(i) * Directions;
    Row x_i[Directions], sum[Directions];
    for (int d = 0; d < Directions; ++d) {
      x_i[d] = x[row + d];
      sum[d] = A.values[begin] * x_i[d];  // the diagonal comes first
    }
    for (int k = begin + 1; k < end; ++k) {
      const double a = A.values[k];
      const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(A.columns[k]) * Directions;
      for (int d = 0; d < Directions; ++d) {
        sum[d] += a * x[j + d];
        y[j + d - y_begins] += a * x_i[d];
      }
    }
    for (int d = 0; d < Directions; ++d) y[row + d - y_begins] += sum[d];
  }
}

template <int W, int Directions>
FLEXURA_INLINE void multiply_rows(const UpperCsr& A, const double* x, double* y) {
  std::fill_n(y, static_cast<std::ptrdiff_t>(A.n) * Directions * W, 0.0);
  add_rows<W, Directions>(A, 0, A.n, x, y);
}

// Likewise with shares of the rows on two cores.  The second one's begin in the middle and reach no row above, so that
// what it has made is half a vector; more cores would wait for memory.
template <int W, int Directions>
void multiply_halves(const UpperCsr& A, const double* x, double* y) {
  const auto half = std::lower_bound(A.row_begin.begin(), A.row_begin.end(), A.row_begin[A.n] / 2);
  const auto middle = static_cast<int>(half - A.row_begin.begin());
  const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(Directions) * W, above = middle * row,
                       all = A.n * row;
  const std::unique_ptr<double[]> lower(new double[static_cast<std::size_t>(all - above)]);
  parallel_for(2, [&](int share) {
    on_wide_registers([&]() __attribute__((always_inline)) {
      if (share == 0) {
        std::fill_n(y, all, 0.0);
        add_rows<W, Directions>(A, 0, middle, x, y);
      } else {
        std::fill_n(lower.get(), all - above, 0.0);
        add_rows<W, Directions>(A, middle, A.n, x, lower.get(),
                                static_cast<std::ptrdiff_t>(middle) * Directions);
      }
    });
  });
  for (std::ptrdiff_t k = above; k < all; ++k) y[k] += lower[static_cast<std::size_t>(k - above)];
}

template <int W>
void multiply_columns(const UpperCsr& A, int directions, const Eigen::Ref<const Eigen::MatrixXd>& X,
                      Eigen::Index first, Eigen::Index count, Eigen::MatrixXd& Y) {
  const std::size_t n_rows = static_cast<std::size_t>(X.rows());
  const std::unique_ptr<double[]> x(new double[n_rows * W]), y(new double[n_rows * W]);
  for (std::size_t r = 0; r < n_rows; ++r)
    for (Eigen::Index c = 0; c < W; ++c)
      x[r * W + c] = c < count ? X(static_cast<Eigen::Index>(r), first + c) : 0.0;
  on_wide_registers([&]() __attribute__((always_inline)) {
    if (directions == 3)
      multiply_rows<W, 3>(A, x.get(), y.get());
    else
      multiply_rows<W, 1>(A, x.get(), y.get());
  });
  for (std::size_t r = 0; r < n_rows; ++r)
    for (Eigen::Index c = 0; c < count; ++c) Y(static_cast<Eigen::Index>(r), first + c) = y[r * W + c];
}

[[noreturn]] void refuse_entry() {
  throw std::runtime_error("adding to a matrix: the entry is outside its pattern");
}

void multiply_panels(const UpperCsr& A, int directions, const Eigen::Ref<const Eigen::MatrixXd>& X,
                     Eigen::MatrixXd& Y) {
  if (X.rows() != static_cast<Eigen::Index>(A.n) * directions)
    throw std::logic_error("multiply: the vectors do not have the length of the matrix");
  Y.resize(X.rows(), X.cols());
  for_each_panel(X.cols(), [&](auto width, Eigen::Index first, Eigen::Index count) {
    multiply_columns<width>(A, directions, X, first, count, Y);
  });
}

}  // namespace

void multiply(const UpperCsr& A, const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) {
  multiply_panels(A, 1, X, Y);
}

struct SymmetricMatrix::Impl {
  std::vector<int> row_begin, columns;
  std::vector<double> values;
  std::vector<std::pair<int, int>> order;  // of add()
  Mat mat = nullptr;                       // a view of the arrays above

  ~Impl() {
    if (mat) MatDestroy(&mat);
  }
};

SymmetricMatrix::SymmetricMatrix(std::vector<int> row_begin, std::vector<int> columns)
    : impl_(std::make_shared<Impl>()) {
  require_session();
  static_assert(sizeof(PetscInt) == sizeof(int), "PETSc with 32-bit indices is expected");
  impl_->row_begin = std::move(row_begin);
  impl_->columns = std::move(columns);
  impl_->values.assign(impl_->columns.size(), 0.0);
  const int n = size();
  petsc_check(MatCreateSeqSBAIJWithArrays(PETSC_COMM_SELF, 1, n, n, impl_->row_begin.data(),
                                          impl_->columns.data(), impl_->values.data(), &impl_->mat),
              "creating a matrix");
  petsc_check(MatSetOption(impl_->mat, MAT_IGNORE_LOWER_TRIANGULAR, PETSC_TRUE), "creating a matrix");
  petsc_check(MatSetOption(impl_->mat, MAT_NEW_NONZERO_LOCATION_ERR, PETSC_TRUE), "creating a matrix");
}

SymmetricMatrix::~SymmetricMatrix() = default;
SymmetricMatrix::SymmetricMatrix(SymmetricMatrix&&) noexcept = default;
SymmetricMatrix& SymmetricMatrix::operator=(SymmetricMatrix&&) noexcept = default;

// Into the arrays that PETSc's matrix looks at: with the dofs in ascending order one walk along each row finds all places,
// where MatSetValues searches for each entry: assembly of 164,277 dofs 0.67 in place of 1.09 s.
void SymmetricMatrix::add(std::span<const int> dofs, const Eigen::MatrixXd& block) {
  std::vector<std::pair<int, int>>& order = impl_->order;  // dof, place in the block
  order.clear();
  for (std::size_t a = 0; a < dofs.size(); ++a)
    if (dofs[a] >= 0) order.emplace_back(dofs[a], static_cast<int>(a));
  std::sort(order.begin(), order.end());
  if (!order.empty() && order.back().first >= size()) refuse_entry();
  for (std::size_t a = 0; a < order.size(); ++a) {
    const auto [row, i] = order[a];
    const int end = impl_->row_begin[row + 1];
    int place = impl_->row_begin[row];
    for (std::size_t b = a; b < order.size(); ++b) {
      const auto [column, j] = order[b];
      if (place < end && impl_->columns[place] < column) ++place;  // nodes have their dofs in a row
      if (place < end && impl_->columns[place] < column) {
        const auto begin = impl_->columns.begin();
        place = static_cast<int>(std::lower_bound(begin + place, begin + end, column) - begin);
      }
      if (place == end || impl_->columns[place] != column) refuse_entry();
      // A dof that is there twice has (i, j) and (j, i) in one place.
      impl_->values[place] += column == row && b != a ? block(i, j) + block(j, i) : block(j, i);
    }
  }
}

void SymmetricMatrix::add_to_diagonal(int dof, double value) {
  impl_->values[impl_->row_begin[dof]] += value;
}

void SymmetricMatrix::add_to_entry(int i, int j, double value) {
  const auto begin = impl_->columns.begin();
  const int row = std::min(i, j), column = std::max(i, j);
  const auto end = begin + impl_->row_begin[row + 1];
  const auto place = std::lower_bound(begin + impl_->row_begin[row], end, column);
  if (place == end || *place != column) refuse_entry();
  impl_->values[static_cast<std::size_t>(place - begin)] += value;
}

SymmetricMatrix SymmetricMatrix::copy() const {
  SymmetricMatrix A(impl_->row_begin, impl_->columns);
  A.impl_->values = impl_->values;  // of the same size: PETSc's view of the array stays valid
  A.finish();
  return A;
}

void SymmetricMatrix::finish() {
  petsc_check(MatAssemblyBegin(impl_->mat, MAT_FINAL_ASSEMBLY), "assembling a matrix");
  petsc_check(MatAssemblyEnd(impl_->mat, MAT_FINAL_ASSEMBLY), "assembling a matrix");
}

int SymmetricMatrix::size() const {
  return static_cast<int>(impl_->row_begin.size()) - 1;
}

UpperCsr SymmetricMatrix::csr() const {
  return {size(), impl_->row_begin, impl_->columns, impl_->values};
}

double SymmetricMatrix::diagonal(int dof) const {
  return impl_->values[impl_->row_begin[dof]];
}

void SymmetricMatrix::multiply(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const {
  multiply_panels(csr(), 1, X, Y);
}

void SymmetricMatrix::multiply_magnitudes(const Eigen::Ref<const Eigen::MatrixXd>& X,
                                          Eigen::MatrixXd& Y) const {
  std::vector<double> magnitudes(impl_->values.size());
  std::transform(impl_->values.begin(), impl_->values.end(), magnitudes.begin(),
                 [](double a) { return std::abs(a); });
  multiply_panels({size(), impl_->row_begin, impl_->columns, magnitudes}, 1, X.cwiseAbs(), Y);
}

void SymmetricMatrix::multiply_kron3(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const {
  multiply_panels(csr(), 3, X, Y);
}

void SymmetricMatrix::multiply_kron3(const RowPanel& X, RowPanel& Y, bool on_all_cores) const {
  if (X.rows() != 3 * static_cast<Eigen::Index>(size()))
    throw std::logic_error("multiply: the panel does not have the length of the matrix");
  Y.resize(X.rows(), X.cols());
  constexpr std::size_t kWorthSharing = 20'000;
  if (on_all_cores && n_cores() > 1 && impl_->columns.size() > kWorthSharing) {
    multiply_halves<RowPanel::ColsAtCompileTime, 3>(csr(), X.data(), Y.data());
    return;
  }
  on_wide_registers([&]() __attribute__((always_inline)) {
    multiply_rows<RowPanel::ColsAtCompileTime, 3>(csr(), X.data(), Y.data());
  });
}

}  // namespace flexura::linalg
