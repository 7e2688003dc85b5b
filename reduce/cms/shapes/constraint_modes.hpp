// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/rigid_projection.hpp"
#include "reduce/assembly/tied_solver.hpp"

namespace flexura::reduce {

/// Constraint modes and the static stiffness of the interface (craig_bampton.hpp).
struct ConstraintModes {
  Eigen::MatrixXd Psi;    ///< n_rows x n_b
  Eigen::MatrixXd K_bb;   ///< condensed, n_b x n_b
  double residual = 0.0;  ///< ||K_ii Psi + K_ib|| / ||K_ib||, averages included
  /// How well the solve had the rigid motions (|R_i - Psi R_b| over |R_i|, the worst of six), which Psi and K_bb now have exactly: its
  /// error in all else is of this size.
  double rigid_error = 0.0;
  double rigid_strain = 0.0;  ///< |K_bb R| over |K_bb| |R| of the solve
};

/// Of the model's boundary.
RigidProjection rigid_projection(const TiedModel& model);

/// Where the part falls into several pieces: K_bb without what round-off leaves between them and in the rigid motions of each.
void part_by_pieces(const Part& part, const TiedModel& model, Eigen::MatrixXd& K_bb);

ConstraintModes constraint_modes(const TiedModel& model, const TiedSolver& solver);

}  // namespace flexura::reduce
