// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/tied_solver.hpp"

namespace flexura::reduce {

/// Constraint modes and the static stiffness of the interface (craig_bampton.hpp).
struct ConstraintModes {
  Eigen::MatrixXd Psi;    ///< n_i x n_b
  Eigen::MatrixXd K_bb;   ///< condensed, n_b x n_b
  double residual = 0.0;  ///< ||K_ii Psi + K_ib|| / ||K_ib||, averages included
};

ConstraintModes constraint_modes(const TiedModel& model, const TiedSolver& solver);

}  // namespace flexura::reduce
