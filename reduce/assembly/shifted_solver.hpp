// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "reduce/assembly/model_factor.hpp"

/// K' = K_ii - omega2 M_ii of a tied model within its spectrum, factorised, averaging ties included:
///
///     K' U + A^T mu = F,     A U = 0
///
/// U = K'^-1 (F - A^T mu),  A K'^-1 A^T mu = A K'^-1 F.  By Sylvester's law of inertia the matrix has as many negative
/// pivots as there are fixed-interface eigenvalues below omega2; with averaging ties the count is that of the bordered one,
///
///     In [ K' A^T ; A 0 ] = In(K') + In(-A K'^-1 A^T),
///
/// less one negative for each row of A (N. Gould, Math. Prog. 32 (1985), 90).
namespace flexura::reduce {

class ShiftedSolver {
 public:
  /// Factorises, in `order`, or nested dissection where that is empty.  The model must outlive it.  Needs a linalg::Session;
  /// std::runtime_error where omega2 lies on an eigenvalue.
  ShiftedSolver(const TiedModel& model, double omega2, std::vector<int> order = {},
                const linalg::FactorStorage& storage = {});

  int n_below() const { return n_below_; }  ///< eigenvalues
  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& F) const;

 private:
  const TiedModel& model_;
  ModelFactor factor_;
  Eigen::MatrixXd Z_;  // K'^-1 A^T
  Eigen::PartialPivLU<Eigen::MatrixXd> small_;
  int n_below_ = 0;
};

}  // namespace flexura::reduce
