// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace flexura::linalg {

/// A supernodal Cholesky factor P A P^T = L L^T as CHOLMOD keeps it.  Supernode s holds the columns
/// first_column[s] to first_column[s + 1] of L as one dense matrix, column by column, whose rows are
/// rows[first_row[s]] to rows[first_row[s + 1]]; its own columns come first among them.
struct SupernodalFactor {
  int n = 0, n_supernodes = 0;
  const int* first_column = nullptr;
  const int* first_row = nullptr;
  const int* first_value = nullptr;
  const int* rows = nullptr;
  const double* values = nullptr;
  const int* permutation = nullptr;  ///< row permutation[k] of A is row k of L
};

/// X = A^-1 B for n x k right-hand sides, by panels of eight columns, one panel per core at a time.  A panel
/// is stored by rows: an entry of L meets eight numbers that lie together, and neither is ever copied for the
/// sake of a matrix product, which is what few right-hand sides cost most in a general BLAS.
void supernodal_solve(const SupernodalFactor& L, const Eigen::Ref<const Eigen::MatrixXd>& B,
                      Eigen::MatrixXd& X);

}  // namespace flexura::linalg
