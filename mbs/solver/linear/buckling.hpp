// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "mbs/solver/linear/static_stiffness.hpp"

/// Linear buckling: the factors at which loads take away a mechanism's stiffness.
///
/// With K_0 the stiffness without loads and K_1 that of the equilibrium under them, both in the independent
/// coordinates z of static_stiffness.hpp,
///
///     (K_0 + lambda (K_1 - K_0)) z = 0.
///
/// K_1 - K_0 holds the geometric stiffness of flexible bodies (fidelity "modal-stiffened", ANCF beams) and what
/// loads do to rigid bodies and joints.  It is right as long as the equilibrium is close to the unloaded shape.
///
/// What is stiffness and what is noise follows from the errors E of both: the softest direction u must be stiffer
/// than sqrt(sum u_i^2 E_ij^2 u_j^2), and 1/lambda, an eigenvalue with left and right vectors l and x,
/// l^T K_0 x = 1, larger than the same sum of l and x.
namespace flexura::mbs {

struct BucklingMode {
  double factor = 0.0;    ///< of the loads; negative: with all loads reversed
  double error = 0.0;     ///< what the factor may lack by the errors of the stiffness, relative
  Eigen::VectorXd shape;  ///< of the velocity coordinates q (n_v), largest entry 1
};

struct Buckling {
  std::vector<BucklingMode> modes;  ///< by rising |factor|
  /// Loads change the stiffness in directions where no real factor takes it away: loads that follow the
  /// motion do, and may make it flutter, which is no matter of stiffness alone.
  bool has_complex_factors = false;
  /// Factors beyond this one are not told from none.
  double seen_to = HUGE_VAL;
};

/// Throws std::runtime_error where the two do not have the same independent coordinates, or the unloaded
/// mechanism has a motion without stiffness.
Buckling buckling_modes(const StaticStiffness& unloaded, const StaticStiffness& loaded);

}  // namespace flexura::mbs
