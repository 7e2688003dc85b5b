// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/slice.hpp"

#include <algorithm>
#include <cmath>

namespace flexura::linalg {

using Eigen::Index;
using Eigen::VectorXd;

Known known_pairs(const LanczosSpace::RitzPairs& ritz, double accurate) {
  Known known;
  const Index n = ritz.theta.size();
  while (known.right < n && ritz.theta(known.right) > 0.0 && ritz.estimate(known.right) < accurate)
    ++known.right;
  while (known.left < n && ritz.theta(n - 1 - known.left) < 0.0 &&
         ritz.estimate(n - 1 - known.left) < accurate)
    ++known.left;
  return known;
}

Index end_of(const VectorXd& omega2, Index least) {
  constexpr Index kLast = 5;
  const Index known = omega2.size();
  Index best = 0;
  double widest = kMultiple * std::abs(omega2(known - 1));
  for (Index k = known - 1; k >= least && (best == 0 || known - k <= kLast); --k)
    if (const double gap = omega2(k) - omega2(k - 1); gap > widest) {
      widest = gap;
      best = k;
    }
  return best;
}

Index largest_cluster(const Slice& slice, const LanczosSpace::RitzPairs& ritz, const Known& known) {
  const VectorXd above = slice.sigma + ritz.theta.head(known.right).array().inverse(),
                 below = slice.sigma + ritz.theta.tail(known.left).array().inverse();
  return std::max(largest_cluster(above, kMultiple), largest_cluster(below, kMultiple));
}

double first_of(const Slice& slice, const LanczosSpace::RitzPairs& ritz) {
  return slice.n_left > 0 ? slice.sigma + 1.0 / ritz.theta(ritz.theta.size() - slice.n_left) : slice.sigma;
}

Neighbour neighbour(const Slice& slice, const LanczosSpace::RitzPairs& ritz) {
  const Index next = ritz.theta.size() - 1 - slice.n_left;
  if (next < 0 || !(ritz.theta(next) < 0.0)) return {};
  return {slice.sigma + 1.0 / ritz.theta(next), std::abs(ritz.estimate(next) / ritz.theta(next))};
}

}  // namespace flexura::linalg
