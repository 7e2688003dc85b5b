// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/assembly/tied_solver.hpp"
#include "reduce/cms/result/options.hpp"
#include "reduce/cms/shapes/constraint_modes.hpp"
#include "reduce/cms/shapes/craig_chang.hpp"
#include "reduce/cms/shapes/ritz_check.hpp"

/// The shapes of a reduction, whichever mode set they belong to: those with one for each interface dof and those with none.
/// All are K- and M-orthogonal, through one Rayleigh-Ritz.
namespace flexura::reduce {

struct Basis {
  Eigen::MatrixXd U_b;     ///< n_i x n_b: in the interior, 1 on the boundary
  Eigen::MatrixXd Phi;     ///< n_i x n_q: 0 on the boundary, Phi^T M_ii Phi = 1
  Eigen::VectorXd omega2;  ///< n_q: Phi^T K_ii Phi [rad^2/s^2]
  Eigen::MatrixXd K_bb;    ///< n_b x n_b: U_b^T K U_b
};

/// Free-free modes and attachment modes (craig_chang.hpp), brought to interface dofs.
Basis craig_chang_basis(const Part& part, const TiedModel& model, const HeldAnswers& held,
                        const ConstraintModes& constraint, const ReductionOptions& options,
                        ReductionReport& report);

/// Constraint modes with the fixed-interface normal modes `pairs`, which response and load shapes join.  `Mhat` as in
/// response_modes.hpp; not read where no response is asked for.  Checked by require_ritz().
Basis fixed_interface_basis(const Part& part, const TiedModel& model, const TiedSolver& solver,
                            const linalg::EigenProblem& problem, const ConstraintModes& constraint,
                            const Eigen::MatrixXd& Mhat, linalg::EigenPairs&& pairs,
                            const ReductionOptions& options, ReductionReport& report);

}  // namespace flexura::reduce
