// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "reduce/linalg/dense/factor_figures.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/factor/factor_store.hpp"

namespace flexura::linalg {

/// A factorisation A = L S L^T of an indefinite symmetric matrix, for its inertia: by Sylvester's law K -
/// sigma M has as many negative pivots as there are eigenvalues below sigma.  It is computed by PETSc's
/// solver package fronts, or by MUMPS where the user's options name it; others count no pivots.
///
/// In fronts there is no pivoting (shifts lie low in the spectrum, so few pivots are negative, and none is small unless
/// sigma is all but an eigenvalue of a piece of the structure held at its separators).  In place of it each
/// factor is put to the test: what round-off has added to the matrix must be small where the matrix itself
/// is, on the vectors nearest to its null space.  These dominate x = A^-1 b for a random b, so the residual
/// of such solves says whether an eigenvalue may have crossed zero (refinement.hpp).
class IndefiniteFactor {
 public:
  /// `order`: row order[k] is eliminated as number k; nested dissection where it is empty.
  /// std::runtime_error where a pivot is zero or the test fails: the limit must be moved a little.
  explicit IndefiniteFactor(const SymmetricMatrix& A, std::vector<int> order = {},
                            const FactorStorage& storage = {});

  ~IndefiniteFactor();
  IndefiniteFactor(IndefiniteFactor&&) noexcept;
  IndefiniteFactor& operator=(IndefiniteFactor&&) noexcept;

  int n_negative() const;
  const FactorFigures& figures() const;
  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::linalg
