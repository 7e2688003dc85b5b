// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "reduce/cms/result/reduction.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"

/// What every reduction must keep, in whatever way its shapes were found; a superelement that does not is not
/// written.
///
/// A reduced model is a Rayleigh-Ritz projection: K_se = T^T K T and M_se = T^T M T of the full model.  Then
/// no frequency lies below the full model's (Courant's minimax theorem; B. N. Parlett, The Symmetric
/// Eigenvalue Problem, 10-2).  A coupling in K that is left out breaks it.
namespace flexura::reduce {

/// The exact answer of the held part to a load whose shape is kept.
struct StaticAnswer {
  std::string load;
  Eigen::VectorXd f_i;  ///< n_i [N]
  double work = 0.0;    ///< f_i^T K_ii^-1 f_i [J]
};

/// Checks Phi^T K_ii Phi = diag(omega2) on a few combinations of the shapes, and that each kept load's answer
/// does the full model's work to 1e-8.  std::runtime_error with the figures.
void require_ritz(const linalg::EigenProblem& problem, const Eigen::MatrixXd& Phi,
                  const Eigen::VectorXd& omega2, const std::vector<StaticAnswer>& answers);

/// Not more of the reduced eigenvalues omega2 with held interfaces lie below the certificate's limit than the
/// full model has there.
void require_not_below(const Eigen::VectorXd& omega2, const ReductionReport& report);

}  // namespace flexura::reduce
