// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/tied_solver.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"

namespace flexura::reduce {

/// What K_ii and M_ii of a model, which must outlive it, do to its vectors; nothing is said of the space and of solves.
linalg::EigenProblem interior_problem(const TiedModel& model);

/// The fixed-interface eigenproblem K_ii phi = omega^2 M_ii phi of a model and its solver, which must outlive it; `storage` is
/// for the factors of its shifts.
linalg::EigenProblem fixed_interface_problem(const TiedModel& model, const TiedSolver& solver,
                                             const linalg::FactorStorage& storage = {});

}  // namespace flexura::reduce
