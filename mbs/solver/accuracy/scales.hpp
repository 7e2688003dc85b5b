// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// How large things are in a mechanism, so that no tolerance depends on the units that its maker thinks in.
namespace flexura::mbs {

struct Scales {
  /// Across the mechanism [m]: the diagonal of the box around what moves, as it is first put together.
  double length = 1.0;
  /// How far what moves lies from the origin [m]: its positions have the round-off of numbers of this size.
  double farthest = 0.0;
  /// The displacement [m] that one unit of a position (n_p) or a velocity (n_v) stands for, somewhere in the
  /// mechanism: 1 for lengths, `length` for angles, of a mode that of the body's point that moves most.
  Eigen::VectorXd reach_p, reach_v;
  /// The highest frequency [rad/s] that each velocity takes part in (n_v), of coordinates of bodies that bend far, whose
  /// stiffness is a matrix; 0 of all others.
  Eigen::VectorXd frequency;
};

}  // namespace flexura::mbs
