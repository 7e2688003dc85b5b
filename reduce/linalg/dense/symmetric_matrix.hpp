// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

namespace flexura::linalg {

/// The upper triangle (diagonal included) of a symmetric sparse matrix by rows; read by columns it is the
/// lower triangle.  Column indices ascend in each row, the diagonal entry comes first.
struct UpperCsr {
  int n = 0;
  std::span<const int> row_begin;  ///< n + 1
  std::span<const int> columns;
  std::span<const double> values;
};

/// Y = A X for n x k dense X; columns are spread over the processor's cores.
void multiply(const UpperCsr& A, const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y);

/// Eight vectors stored by rows, as products with sparse matrices want them.
using RowPanel = Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor>;

/// A symmetric sparse matrix, assembled in PETSc (SBAIJ).  Needs a Session.
class SymmetricMatrix {
 public:
  /// The sparsity pattern: upper triangle, each row sorted and beginning with its diagonal entry.
  SymmetricMatrix(std::vector<int> row_begin, std::vector<int> columns);
  ~SymmetricMatrix();
  SymmetricMatrix(SymmetricMatrix&&) noexcept;
  SymmetricMatrix& operator=(SymmetricMatrix&&) noexcept;

  /// Adds a dense symmetric block: entry (i, j) of `block` goes to (dofs[i], dofs[j]).  Rows with a negative
  /// dof are skipped.  Throws std::runtime_error for an entry outside the pattern.
  void add(std::span<const int> dofs, const Eigen::MatrixXd& block);
  /// Adds to one diagonal entry.
  void add_to_diagonal(int dof, double value);
  /// Adds to entry (i, j) = (j, i).  Throws std::runtime_error for an entry outside the pattern.
  void add_to_entry(int i, int j, double value);
  /// Ends the assembly; needed once before anything is read.
  void finish();

  SymmetricMatrix copy() const;
  int size() const;
  UpperCsr csr() const;
  double diagonal(int dof) const;

  /// Y = A X for n x k dense X; columns are spread over the processor's cores.
  void multiply(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const;
  /// Y = |A| |X|, entry by entry: eps Y bounds what rounding the entries of X does to A X.
  void multiply_magnitudes(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const;
  /// Y = (A (x) I_3) X: A acts on each of the three directions alike.  X is 3n x k, row 3 i + a.
  void multiply_kron3(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const;
  void multiply_kron3(const RowPanel& X, RowPanel& Y, bool on_all_cores = false) const;

  /// The numbers live as long as this or the matrix.
  std::shared_ptr<const void> share() const { return impl_; }

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace flexura::linalg
