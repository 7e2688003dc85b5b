// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

#include "reduce/linalg/dense/factor_figures.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/factor/row_exchange.hpp"
#include "reduce/linalg/petsc/team.hpp"

struct _p_PetscViewer;  // PETSc's, which only .cpp files see

namespace flexura::linalg {

/// A symmetric matrix A = sum of what each rank of a team holds, factorised by MUMPS over all ranks (L D L^T
/// with pivoting; P. R. Amestoy et al., SIAM J. Matrix Anal. Appl. 23 (2001), 15): a row of A lies on the
/// rank that owns it, L on all.  Every function is collective, within Team::in_step().
class DistributedFactor {
 public:
  /// This rank's terms, of the rows known here.
  struct Terms {
    UpperCsr matrix;
    /// What holds these numbers, where nobody else needs them: they are gone before the factorisation begins.
    std::shared_ptr<const void> held_by = nullptr;
    /// (number among those of all ranks, value) to be added to the diagonal.
    std::vector<std::pair<int, double>> diagonal = {};
  };
  enum class Use {
    solve,
    count,  ///< pivots only: L is not kept, which takes a third of the memory
  };
  /// std::runtime_error on all ranks where it fails.
  DistributedFactor(const Team& team, Terms terms, const RowShares& rows, Use use = Use::solve);
  ~DistributedFactor();
  DistributedFactor(const DistributedFactor&) = delete;
  DistributedFactor& operator=(const DistributedFactor&) = delete;

  /// Each rank gives its rows of B and gets those of A^-1 B.
  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const;
  /// Writes PETSc's report of the factor to its viewer, which is that of all processes.
  void view(_p_PetscViewer* viewer) const;

  /// Pivots; a zero one is below 1e-13 of what the matrix has there (rank-revealing ones of MUMPS).  The same
  /// on all ranks.
  int n_negative() const;
  int n_zero() const;
  const FactorFigures& figures() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::linalg
