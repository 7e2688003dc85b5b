// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"

/// Equilibrium: the state at rest that needs no acceleration,
///
///     f(p, 0, c, a, t) = G^T lambda,  g = 0,  f_c = 0,  b = 0.
///
/// Each step solves
///
///     [ K + sigma D   G^T ] [ d      ]     [ r ]
///     [ G             0   ] [ dlambda] = - [ g ],     p <- retract(p, alpha d)
///
/// with the diagonal D of the mass matrix.  sigma is 0 (Newton's method) where K is positive
/// definite on the null space of G, and otherwise large enough to make it so: d leads downhill then, alpha ends where the
/// energy falls no longer along it (r . d changes its sign), and the iteration ends in a stable equilibrium.  Near by sigma is 0, too, where all eigenvalues of an
/// unsymmetric K (of moments about axes that stand still) lie to the right.  Unstable ones are found with
/// sigma = 0 throughout.
///
/// Dynamic states that only motion changes are springs from where the search began (FollowingStates).  Limits that are switches, of
/// a friction that sticks, are passed: it slides to its place, and sticks there.
///
/// In place of its row of G a drive of speed or acceleration that follows states or the motion has the speed that it asks for, which
/// is 0 at rest.  Where that leads it to no place (J is singular) it stays at its own, by one equation more in least squares; others,
/// and what rolls, stay by their row of G.
namespace flexura::mbs {

struct StaticsOptions {
  double tolerance = 1e-10;  ///< last step relative to the typical sizes of the positions
  int max_iterations = 500;
  bool stable = true;  ///< false: pure Newton, to the equilibrium nearest by, stable or not
  /// Empty, or what the constraints are held at in place of 0, near which s must begin then.
  Eigen::VectorXd opening;
  /// Null, or the same equations without given loads, which count with 1 - load, and eq with load.
  const Equations* unloaded = nullptr;
  double load = 1.0;
};

struct StaticsReport {
  int iterations = 0;
  double force_residual = 0.0;       ///< largest |r|, N or N m
  double constraint_residual = 0.0;  ///< largest |g|
  /// Dynamic states that only motion changes and that exert forces (of a friction that sticks): the equilibrium depends on where
  /// the search began.
  std::vector<std::string> following_the_way;
  bool stable = true;  ///< false: where the loads led, and not known to be stable
};

/// Moves s.p, s.c, s.a, s.lambda into equilibrium at s.t with s.v = 0.  Throws std::runtime_error naming the
/// coordinate with the largest unbalanced force, AssemblyError where the loops do not close.
StaticsReport solve_statics(const Equations& eq, State& s, const StaticsOptions& options = {});

}  // namespace flexura::mbs
