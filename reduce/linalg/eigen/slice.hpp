// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <limits>

#include "reduce/linalg/eigen/block_lanczos.hpp"
#include "reduce/linalg/eigen/lanczos_space.hpp"

// What is known on both sides of a shift; for spectrum_slices.cpp.
namespace flexura::linalg {

/// Eigenvalues as near to one another as this fraction are one that is multiple.  Thousands of modes come as near as kClusterGap
/// by chance.
inline constexpr double kMultiple = 1e-6;

/// An operator (K - sigma M)^-1 M of which the nearest eigenvalues on both sides of sigma are wanted.
struct Slice {
  double sigma = 0.0;
  EigenProblem::Operator solve;
  Eigen::Index n_left = 0;       ///< below sigma, no more and no fewer
  Eigen::Index least_right = 0;  ///< above
};

/// Accurate pairs at the ends of the descending theta: those right of sigma at the beginning, those left of it at the end.
struct Known {
  Eigen::Index right = 0, left = 0;
};
Known known_pairs(const LanczosSpace::RitzPairs& ritz, double accurate);

/// Where to end on the right: the widest of the last gaps that part vectors well, or else the next such gap; 0: not yet.
Eigen::Index end_of(const Eigen::VectorXd& omega2, Eigen::Index least);

/// Members of the largest cluster among the accurate pairs of either side.
Eigen::Index largest_cluster(const Slice& slice, const LanczosSpace::RitzPairs& ritz, const Known& known);

/// The first that a slice takes on the left, or the shift itself.
double first_of(const Slice& slice, const LanczosSpace::RitzPairs& ritz);

/// The next one below it, and how near to an eigenvalue it is.
struct Neighbour {
  double omega2 = 0.0, error = std::numeric_limits<double>::infinity();
};
Neighbour neighbour(const Slice& slice, const LanczosSpace::RitzPairs& ritz);

}  // namespace flexura::linalg
