// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/symmetric_matrix.hpp"

#include <petscmat.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "reduce/linalg/parallel.hpp"
#include "reduce/linalg/petsc_check.hpp"

namespace flexura::linalg {
namespace {

constexpr int kWidth = 4;  // columns handled together: one pass over the matrix for four products

// y += A x for kWidth interleaved columns of `Dirs` interleaved directions.
template <int Block>
void multiply_block(const UpperCsr& A, const double* x, double* y) {
  for (int i = 0; i < A.n; ++i) {
    const int begin = A.row_begin[i], end = A.row_begin[i + 1];
    const double* xi = x + static_cast<std::ptrdiff_t>(i) * Block;
    double* yi = y + static_cast<std::ptrdiff_t>(i) * Block;
    double sum[Block];
    for (int c = 0; c < Block; ++c) sum[c] = A.values[begin] * xi[c];  // the diagonal comes first
    for (int k = begin + 1; k < end; ++k) {
      const double a = A.values[k];
      const std::ptrdiff_t j = static_cast<std::ptrdiff_t>(A.columns[k]) * Block;
      for (int c = 0; c < Block; ++c) {
        sum[c] += a * x[j + c];
        y[j + c] += a * xi[c];
      }
    }
    for (int c = 0; c < Block; ++c) yi[c] += sum[c];
  }
}

template <int Directions>
void multiply_columns(const UpperCsr& A, const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) {
  const Eigen::Index rows = static_cast<Eigen::Index>(A.n) * Directions, n_cols = X.cols();
  if (X.rows() != rows) throw std::logic_error("multiply: the vectors do not have the length of the matrix");
  Y.resize(rows, n_cols);
  const int n_chunks = static_cast<int>((n_cols + kWidth - 1) / kWidth);
  parallel_for(n_chunks, [&](int chunk) {
    const Eigen::Index first = static_cast<Eigen::Index>(chunk) * kWidth;
    const int width = static_cast<int>(std::min<Eigen::Index>(kWidth, n_cols - first));
    if (width == 1 && Directions == 1) {
      Y.col(first).setZero();
      multiply_block<1>(A, X.col(first).data(), Y.col(first).data());
      return;
    }
    // Row 3 i + a of column c goes to place (i, a, c): what is multiplied by one matrix entry lies together.
    std::vector<double> x(static_cast<std::size_t>(rows) * kWidth, 0.0), y(x.size(), 0.0);
    for (int c = 0; c < width; ++c)
      for (Eigen::Index r = 0; r < rows; ++r) x[r * kWidth + c] = X(r, first + c);
    multiply_block<Directions * kWidth>(A, x.data(), y.data());
    for (int c = 0; c < width; ++c)
      for (Eigen::Index r = 0; r < rows; ++r) Y(r, first + c) = y[r * kWidth + c];
  });
}

}  // namespace

struct SymmetricMatrix::Impl {
  std::vector<int> row_begin, columns;
  std::vector<double> values;
  Mat mat = nullptr;  // a view of the arrays above

  ~Impl() {
    if (mat) MatDestroy(&mat);
  }
};

SymmetricMatrix::SymmetricMatrix(std::vector<int> row_begin, std::vector<int> columns)
    : impl_(std::make_unique<Impl>()) {
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

void SymmetricMatrix::add(std::span<const int> dofs, const Eigen::MatrixXd& block) {
  const int n = static_cast<int>(dofs.size());
  // PETSc reads by rows, Eigen stores by columns: the block is symmetric, so both are the same.
  petsc_check(MatSetValues(impl_->mat, n, dofs.data(), n, dofs.data(), block.data(), ADD_VALUES),
              "adding to a matrix");
}

void SymmetricMatrix::add_to_diagonal(int dof, double value) {
  impl_->values[impl_->row_begin[dof]] += value;
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
  multiply_columns<1>(csr(), X, Y);
}

void SymmetricMatrix::multiply_magnitudes(const Eigen::Ref<const Eigen::MatrixXd>& X,
                                          Eigen::MatrixXd& Y) const {
  std::vector<double> magnitudes(impl_->values.size());
  std::transform(impl_->values.begin(), impl_->values.end(), magnitudes.begin(),
                 [](double a) { return std::abs(a); });
  multiply_columns<1>({size(), impl_->row_begin, impl_->columns, magnitudes}, X.cwiseAbs(), Y);
}

void SymmetricMatrix::multiply_kron3(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const {
  multiply_columns<3>(csr(), X, Y);
}

}  // namespace flexura::linalg
