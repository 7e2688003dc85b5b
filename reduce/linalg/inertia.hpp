// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

#include "reduce/linalg/symmetric_matrix.hpp"

namespace flexura::linalg {

/// A factorisation A = L D L^T of an indefinite symmetric matrix (MUMPS through PETSc), for its inertia: by
/// Sylvester's law K - sigma M has as many negative pivots as there are eigenvalues below sigma.
class IndefiniteFactor {
 public:
  /// The matrix must outlive the factor.  std::runtime_error where MUMPS fails or a pivot is zero.
  explicit IndefiniteFactor(const SymmetricMatrix& A);
  ~IndefiniteFactor();
  IndefiniteFactor(const IndefiniteFactor&) = delete;
  IndefiniteFactor& operator=(const IndefiniteFactor&) = delete;

  int n_negative() const;
  Eigen::MatrixXd solve(const Eigen::MatrixXd& B) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::linalg
