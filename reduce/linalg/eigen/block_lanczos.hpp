// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <limits>

#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/eigen/lanczos_basis.hpp"

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
///
/// This runs as an eigensolver type of SLEPc (block_lanczos_type.hpp), the default of eigensolver.hpp.
struct BlockLanczosSettings {
  int block = 16;          ///< right-hand sides together
  int most_vectors = 0;    ///< of the basis at first; 0: what the request suggests
  int most_blocks = 2000;  ///< solves
  /// Refuses (std::invalid_argument) where eigenvalues are seen below the shift: they would be left out.
  bool none_below = false;
  VectorStorage storage;  ///< of the basis; empty: of its own
  /// Called with what is known at every look at H: eigenvalues, their relative residuals in S, how many leading ones
  /// are accurate already, blocks solved for.
  std::function<void(const Eigen::VectorXd& omega2, const Eigen::VectorXd& estimate, Eigen::Index known,
                     int n_blocks)>
      look;
};
EigenPairs iterate_block_lanczos(const EigenProblem& problem, const EigenRequest& request,
                                 const BlockLanczosSettings& settings, const Progress& progress = {});

/// Members of the largest cluster of ascending eigenvalues, each nearer to the next than this fraction of it.
Eigen::Index largest_cluster(const Eigen::Ref<const Eigen::VectorXd>& omega2, double gap);

/// Right-hand sides together, for `count` pairs.  Narrow blocks need a third less of them; wide ones pass along a long basis
/// half as often.
int block_lanczos_width(int count);

/// How many vectors of the problem's length the basis holds at most, for `count` pairs, where there is room for `room` of them.
/// All of them spare restarts; these cost little (a quarter more processor time with 4/3 of the pairs, 80,000 unknowns), and
/// a basis with restarts has a third of the length.
int block_lanczos_vectors(int count, int block = 16, double room = std::numeric_limits<double>::infinity());

}  // namespace flexura::linalg
