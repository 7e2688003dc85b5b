// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/cms/result/reduction.hpp"

/// What damps a part by itself, on its shapes:
///
///     D_se = P^T (T^T D_FEM T) P + M Y W^-1/2 (Y^T K_loss Y) W^-1/2 Y^T M,     P = 1 - R (R^T M R)^-1 R^T M
///
/// with D_FEM of dampers, of a matrix that was given, and of materials (alpha M_e + beta K_e).  K_loss = sum of loss factors
/// times stiffness is structural damping, K (1 + i loss): as viscous damping at the frequency of each elastic mode y_j of the
/// free superelement, W = diag(omega_j), so that y_j has the ratio loss/2 (R. W. Clough, J. Penzien, Dynamics of Structures,
/// 3-7).  P takes out what resists rigid motion, for which the mechanism has forces of its own.
namespace flexura::reduce {

/// D_se of a part whose K_se and M_se are known, on rank 0 of a team; empty where nothing damps.  `T`: the shapes on the nodes
/// here, 3 n_nodes x n; `rotations`: 3 n_rotations x n, or empty where there are none.  Collective.
Eigen::MatrixXd damping_matrix(const Part& part, const TiedModel& model, const Eigen::MatrixXd& T,
                               const Eigen::MatrixXd& rotations, Reduction& reduction);

/// P^T D P with rigid motions R (n x 6); what it took out is said in the report where it is more than printed digits leave.
Eigen::MatrixXd without_rigid_damping(const Eigen::MatrixXd& D, const Eigen::MatrixXd& R,
                                      const Eigen::MatrixXd& M, ReductionReport& report);

}  // namespace flexura::reduce
