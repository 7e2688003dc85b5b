// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/solver/linear/steady_state.hpp"

/// What a natural mode of a steadily turning mechanism is in axes that stand still.
///
/// Its coordinates turn with Omega n (found by how the bodies' displacements follow them along the motion).
/// The part of u exp(i w t) across n is two circular whirls, F with n at w and B against it at -w,
///
///     u_1 + i u_2 = F exp(i w t) + B exp(-i w t),    F = (U_1 + i U_2) / 2,   B = conj(U_1 - i U_2) / 2,
///
/// which in axes that stand still have the speeds Omega + w and Omega - w; what moves along n and turns about
/// it keeps w.  A mode of a rotor that is round, on supports that are round, is one of these alone.
namespace flexura::mbs {

struct Whirl {
  enum class Kind { circular, along };
  Kind kind = Kind::circular;
  double hz = 0.0;     ///< circular: positive with the rotation, negative against it
  double share = 0.0;  ///< of the motion of all bodies, squares summed
};

class FixedAxes {
 public:
  /// Of a steady motion with a body that turns; throws std::invalid_argument for others.
  FixedAxes(const Mechanism& mechanism, const State& s, const SteadyLinearisation& about);
  /// Those with more than a thousandth of the motion, largest first; empty where the bodies do not follow
  /// the mode as any turning axes would.
  std::vector<Whirl> of(const NaturalMode& mode) const;

 private:
  Eigen::VectorXcd displacements(const State& s, const Eigen::VectorXcd& d) const;

  const Mechanism& m_;
  const State& s_;
  const SteadyLinearisation& about_;
  std::vector<Vector3d> rates_;  ///< angular velocities of bodies, and none
  Vector3d n_ = Vector3d::Zero();
};

}  // namespace flexura::mbs
