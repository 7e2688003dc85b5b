// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mbs/solver/linearise.hpp"

/// Linear buckling: the factors at which loads take away a mechanism's stiffness.
///
/// With K_0 the stiffness without loads and K_1 that of the equilibrium under them, both in the independent
/// coordinates z of linearise.hpp,
///
///     (K_0 + lambda (K_1 - K_0)) z = 0.
///
/// Dynamic states (of actuators and controls) follow statically: what they answer to z is part of K.
/// K_1 - K_0 holds the geometric stiffness of flexible bodies (fidelity "modal-stiffened") and what loads do
/// to rigid bodies and joints.  It is right as long as the equilibrium is close to the unloaded shape.
namespace flexura::mbs {

struct BucklingMode {
  double factor = 0.0;    ///< of the loads; negative: with all loads reversed
  Eigen::VectorXd shape;  ///< of the velocity coordinates q (n_v), largest entry 1
};

struct Buckling {
  std::vector<BucklingMode> modes;  ///< by rising |factor|
  /// Loads change the stiffness in directions where no real factor takes it away: loads that follow the
  /// motion do, and may make it flutter, which is no matter of stiffness alone.
  bool has_complex_factors = false;
};

/// Throws std::runtime_error where the two systems do not have the same independent coordinates, the unloaded
/// mechanism has a motion without stiffness or a dynamic state has no static value.
Buckling buckling_modes(const LinearSystem& unloaded, const LinearSystem& loaded);

}  // namespace flexura::mbs
