// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/equations/equations.hpp"

namespace flexura::mbs {

/// Rows of G, by their index.
struct Redundancy {
  std::vector<int> kept, left_out;
  std::vector<std::vector<int>>
      follows_from;  ///< of each row left out: kept ones that it is a combination of
};

/// Which rows say nothing new at the configuration p and near it.  `scale` is what a coordinate changes by in a motion as
/// large as the mechanism, `is_modal` whether it is a modal coordinate (n_v); rows `of_positions` are kept before others, and those that `last` say where the mechanism
/// may be at all times.
Redundancy find_redundancy(const Equations& mechanism, When when, ConstVectorRef p,
                           const Eigen::VectorXd& scale, const std::vector<bool>& is_modal,
                           const std::vector<bool>& of_positions, const std::vector<bool>& lasts);

/// What the rows of G beside the kept ones follow from.
Redundancy with_kept(const Eigen::MatrixXd& G, std::vector<int> kept);

/// Those n among the candidates that hold most, one after the other: rows that come near to vanishing, which normalised pass for
/// a direction, come last. `G` in units of its rows and of the mechanism. Empty where there are fewer.
std::vector<int> most_independent(const Eigen::MatrixXd& G, const std::vector<int>& candidates, int n);

}  // namespace flexura::mbs
