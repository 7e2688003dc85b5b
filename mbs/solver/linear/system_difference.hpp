// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/linear/linearise.hpp"

namespace flexura::mbs {

/// Coefficients that differ by less of their own size are the same: central differences leave 1e-9, the positions along a
/// motion 1e-10, and what a run settles to lacks some 1e-5.
inline constexpr double kSameCoefficient = 1e-4;

/// What entries of a system are measured by.
struct TypicalSizes {
  const Eigen::VectorXd& velocity;  ///< of each velocity coordinate
  Eigen::VectorXd dynamic;          ///< of each dynamic state among x
  double acceleration;              ///< at hand, in typical sizes
};

/// A system of a later instant; `B` (n_v x n_v) brings velocities of the first there.
struct LaterSystem {
  LinearSystem system;
  Eigen::MatrixXd B;
};

/// The largest difference of two systems' A relative to what it couples, in balanced coordinates.  `where`: the column of (z, c)
/// that it is found in.
double largest_difference(const LinearSystem& at_0, const LaterSystem& then, const TypicalSizes& sizes,
                          int& where);

/// The largest difference of a column of B or a row of C relative to itself.  What differs by as much at once, in the systems of the next
/// moment, is round-off: of a torque that a hinge does not transmit nothing else is left.
/// `where`: the input or the output.
double largest_coupling_difference(const LinearSystem& at_0, const LaterSystem& at_once,
                                   const LaterSystem& then, const LaterSystem& soon_after,
                                   const TypicalSizes& sizes, std::string& where);

}  // namespace flexura::mbs
