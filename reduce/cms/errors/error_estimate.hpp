// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/cms/result/reduction.hpp"

/// What the dropped fixed-interface modes cost in accuracy, from quantities that the reduction has at hand.
///
/// For a mass-normalised mode u = (u_b, eta) of the reduced model with eigenvalue lambda, the relative error
/// of lambda is to leading order e_0,
///
///     e_0 = lambda a,   a = u_b^T Mhat^T F_rs Mhat u_b,
///     Mhat = M_ib + M_ii Psi,   F_rs = K_ii^-1 - Phi Omega^-2 Phi^T
///
/// (J.-H. Kim, S.-H. Boo, P.-S. Lee, Comput. Struct. 150 (2015), 12); the frequency's error is half of it.
/// The dropped modes answer at lambda stronger than at rest, each by 1 / (1 - lambda / omega_j^2), so that
/// e_0 / (1 - lambda / omega_c^2), omega_c^2 being the first dropped eigenvalue, leans to the safe side.
///
/// The estimate itself is better: the residual shapes X = F_rs Mhat join the reduced model as a second basis.
/// They are K- and M-orthogonal to the kept modes, and their matrices are those at hand,
///
///     X^T K_ii X = Mhat^T X = Mhat^T F_rs Mhat,    X^T M_ii X = Mhat^T F_rs M_ii F_rs Mhat,
///
/// so the eigenvalues lambda+ with them cost a small eigenproblem.  By Rayleigh and Ritz they lie between the
/// true ones and lambda, and e = lambda / lambda+ - 1 is a lower bound of the true error, mode by mode in
/// their order.
///
/// Measured on twelve bodies (tests/reduce/error_estimate_test.cpp): e is 0.8 to 1 of the true error for
/// isolated modes below lambda = omega_c^2 / 2, the safe form never below 1.  Pairs of close modes share
/// their errors: judge their sum.
namespace flexura::reduce {

struct ModeError {
  double omega2 = 0.0;         ///< reduced eigenvalue [rad^2/s^2]
  double estimate = 0.0;       ///< relative error of omega2
  double safe_estimate = 0.0;  ///< the safe form; infinite where lambda >= omega_c^2
  bool isolated = true;        ///< the gaps to the neighbours are above 5 % and twice the estimates of both
};

/// Estimates for all elastic modes of the body with the boundary dofs in `held` fixed (none: free),
/// ascending.
std::vector<ModeError> mode_errors(const Reduction& reduction, const std::vector<int>& held = {});

/// The largest relative error of the interface's dynamic stiffness up to omega [rad/s]: the part of the
/// dropped modes, omega^4 Mhat^T F_rs Mhat / (1 - omega^2 / omega_c^2), against the interface's mass, omega^2
/// M_bb, as the largest eigenvalue of the pencil.
double interface_error(const Reduction& reduction, double omega);

}  // namespace flexura::reduce
