// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/linalg/eigen_problem.hpp"
#include "reduce/linalg/progress.hpp"

namespace flexura::linalg {

/// Lowest eigenpairs by block Lanczos with full reorthogonalisation in the M inner product and thick
/// restarts:
///
///     S = (K + shift M)^-1 M,   S V = V H + V_next R E^T,   V^T M V = 1,   H = V^T M S V
///
/// Right-hand sides are solved for in blocks, which costs a fraction of single solves.  Ritz vectors y of H
/// give phi = S V y / theta = V y + V_next R y_last / theta: one more application of S, free of charge, which
/// removes the short waves from the error (B. Nour-Omid et al., Math. Comp. 48 (1987), 663). R. G. Grimes, J.
/// G. Lewis, H. D. Simon, SIAM J. Matrix Anal. Appl. 15 (1994), 228; K. Wu, H. Simon, 22 (2000), 602.
///
/// Every pair's residual is measured with K and M; iterations go on until all are below the tolerance.
/// Throws std::runtime_error when they do not get there.
EigenPairs block_lanczos(const EigenProblem& problem, const EigenRequest& request,
                         const Progress& progress = {}, int block = 16);

/// How many vectors of the problem's length the basis holds at most, for `count` pairs.
int block_lanczos_vectors(int count, int block = 16);

}  // namespace flexura::linalg
