// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/linear/linearise.hpp"

namespace flexura::mbs {

/// Coefficients that differ by less of their own size are the same: central differences leave 1e-9, the positions along a
/// motion 1e-10.
inline constexpr double kSameCoefficient = 1e-5;

/// What entries of a system are measured by.
struct TypicalSizes {
  const Eigen::VectorXd& velocity;  ///< of each velocity coordinate
  Eigen::VectorXd dynamic;          ///< of each dynamic state among x
  double acceleration;              ///< at hand, in typical sizes
};

/// The largest difference of two systems' matrices relative to what they couple, in balanced coordinates; B (n_v x n_v) brings
/// velocities of the first to the second.  `where`: the column of (z, c) that it is found in.
double largest_difference(const LinearSystem& at_0, const LinearSystem& at_tau, const Eigen::MatrixXd& B,
                          const TypicalSizes& sizes, int& where);

}  // namespace flexura::mbs
