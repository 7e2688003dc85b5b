// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "reduce/linalg/dense/factor_figures.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/factor/factor_store.hpp"

struct _p_PetscViewer;  // PETSc's, which only .cpp files see

namespace flexura::linalg {

/// The matrix has no Cholesky factor, or a pivot that is zero to round-off: the structure can move without
/// strain.
struct SingularMatrix : std::runtime_error {
  SingularMatrix(int dof, const char* text) : std::runtime_error(text), dof(dof) {}
  int dof;  ///< the row at which it was noticed
};

/// A sparse Cholesky factorisation P A P^T = L L^T by PETSc's KSP and PC, which read the user's options; the
/// default is the solver package fronts (fronts_package.hpp; nested dissection by METIS).
class CholeskyFactor {
 public:
  /// `group_begin` cuts the rows into groups of consecutive rows with the same pattern (the directions of one
  /// node), ascending, first 0, last n; the ordering is found on the groups, which is faster.  Empty: each
  /// row its own group.  `doubled` lists rows whose diagonal entry is taken twice: A + E diag(A_pp) E^T is
  /// factorised.  A matrix without rows is no error.  Throws SingularMatrix, or std::runtime_error when neither memory nor the disk suffices.
  explicit CholeskyFactor(const SymmetricMatrix& A, std::span<const int> group_begin = {},
                          std::span<const int> doubled = {}, const FactorStorage& storage = {});
  ~CholeskyFactor();
  CholeskyFactor(CholeskyFactor&&) noexcept;
  CholeskyFactor& operator=(CholeskyFactor&&) noexcept;

  /// X = A^-1 B for n x k right-hand sides, all columns together.
  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const;

  /// Writes PETSc's report of the solver to its viewer.
  void view(_p_PetscViewer* viewer) const;

  int size() const;
  /// Row order()[k] is eliminated as number k; empty where the user's options name another package.
  const std::vector<int>& order() const;
  const FactorFigures& figures() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::linalg
