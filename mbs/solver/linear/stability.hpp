// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/solver/linear/linearise.hpp"

/// Whether a state at rest, or a steady motion, is left by itself after a small disturbance.
///
/// At rest, with forces that have a potential and no dynamic states, the stiffness on the null space of the
/// constraints decides (Lagrange, Dirichlet): positive definite is stable, a negative direction is unstable.
/// K comes from exact derivatives, in units in which every coordinate is as stiff as the others, so that a
/// soft direction is not lost beside stiff ones.  Else the eigenvalues decide.  What lies within the errors
/// of either is unknown: a direction without stiffness, a vibration without damping.
namespace flexura::mbs {

struct Stability {
  enum class Verdict { stable, unstable, unknown };
  Verdict verdict = Verdict::unknown;
  double growth = 0.0;  ///< of what grows fastest [1/s]
  int coordinate = -1;  ///< velocity coordinate that moves most in it or, unknown, that nothing holds
};

/// `s` must be an equilibrium at rest, with its multipliers.
Stability stability_at_rest(const Equations& eq, const State& s);

/// From the eigenvalues of a system with constant coefficients; `rate` [1/s] is that of the motion itself
/// (its speeds in typical sizes).
Stability stability_of(const Equations& eq, const LinearSystem& system, double rate);

/// "the equilibrium is unstable: ..."; empty for a stable one.  `what` is "the equilibrium", ...
std::string sentence(const Equations& eq, const Stability& stability, const std::string& what);

/// "stable", "unstable", "unknown".
std::string name_of(Stability::Verdict verdict);

}  // namespace flexura::mbs
