// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/shared_assembly.hpp"
#include "reduce/cms/result/options.hpp"
#include "reduce/cms/result/reduction.hpp"

/// Craig-Bampton reduction (R. R. Craig, M. C. C. Bampton, AIAA J. 6 (1968), 1313).
///
///     Psi = -K_ii^-1 K_ib                      constraint modes, one for each boundary dof
///     K_ii phi = omega^2 M_ii phi              fixed-interface normal modes, Phi^T M_ii Phi = 1
///     T = [ 1 0 ; Psi Phi ],   K_se = diag(K_bb + K_bi Psi, Omega^2),   M_se = T^T M T
///
/// Averaging ties (tied_model.hpp) enter as A Psi = 1 on their dofs, A Phi = 0; K_bb then gains minus the
/// reactions.  Elastic ties are rigid for Psi and Phi and add interface modes (interface_modes.hpp); the
/// basis of all is brought to the form of shape_change.hpp.
namespace flexura::reduce {

/// Reduces a part with any set of modes.  Needs a linalg::Session.  Throws std::invalid_argument for parts
/// that cannot be reduced (see TiedModel, TiedSolver) and std::runtime_error when a computation fails.
/// Rank 0 of options.team leads the others.
Reduction craig_bampton(const Part& part, const ReductionOptions& options);

/// On each rank of a team, within Team::in_step(), with what it has of `part`, which is `whole` with its elastic ties rigid.
/// Both are parts themselves on rank 0, whose the result is, and share.part on the others.  Fields of loads are by the nodes of
/// share.part, other nodes in the options by those of the whole part.
Reduction craig_bampton(const Part& whole, const Part& part, const PartShare& share,
                        const ReductionOptions& options);

}  // namespace flexura::reduce
