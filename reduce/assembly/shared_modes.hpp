// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/tied_solver.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"

/// Fixed-interface modes by all ranks of a team: each holds its rows of the eigensolver's basis and makes products with
/// its share of K_ii and M_ii, the distributed factor solves.  No rank holds more than its part of the vectors but for
/// rank 0, which gets the modes.
namespace flexura::reduce {

/// On rank 0, for a model whose elements the team shares; SLEPc's Krylov-Schur in place of block Lanczos, unless the
/// user's options name a type.
linalg::EigenPairs find_shared_modes(const TiedSolver& solver, const linalg::EigenRequest& request,
                                     bool krylov_schur, const linalg::Progress& progress);

/// The other ranks' part in it: their share of the model and the factor that solves.
void join_shared_modes(const linalg::Team& team, const TiedMatrices& share, const linalg::RowShares& rows,
                       const linalg::DistributedFactor& factor);

}  // namespace flexura::reduce
