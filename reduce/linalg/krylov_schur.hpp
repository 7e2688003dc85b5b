// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/linalg/eigen_problem.hpp"
#include "reduce/linalg/progress.hpp"

namespace flexura::linalg {

/// Lowest eigenpairs with SLEPc's Krylov-Schur method, shift-and-invert with the problem's own `solve`, one
/// vector at a time.  G. W. Stewart, SIAM J. Matrix Anal. Appl. 23 (2001), 601; J. E. Roman, SLEPc technical
/// report STR-7. Throws std::runtime_error, naming how many converged, when not all asked for do.
EigenPairs krylov_schur(const EigenProblem& problem, const EigenRequest& request,
                        const Progress& progress = {});

}  // namespace flexura::linalg
