// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/part.hpp"
#include "reduce/cms/reduction.hpp"

namespace flexura::reduce {

/// How many fixed-interface eigenvalues lie below omega2 [rad^2/s^2], by Sylvester's law of inertia: the
/// negative pivots of K_ii - omega2 M_ii, assembled and factorised anew.  With averaging ties the count is
/// that of the bordered matrix,
///
///     In [ K' A^T ; A 0 ] = In(K') + In(-A K'^-1 A^T),   K' = K_ii - omega2 M_ii,
///
/// less one negative for each row of A (K. Gould, Math. Prog. 32 (1985), 90).  It proves that an eigensolver
/// has missed none.  Needs a linalg::Session.
int count_modes_below(const Part& part, double omega2);

/// Counts between the last of `n_modes` kept eigenvalues and the first left out (infinite where there is
/// none), and notes both in the report.  std::runtime_error where the counts differ.
void certify(const Part& part, double omega2_last, double omega2_next, int n_modes, ReductionReport& report);

}  // namespace flexura::reduce
