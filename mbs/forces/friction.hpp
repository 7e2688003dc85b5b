// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace flexura::mbs {

/// Dry friction with Stribeck's effect along a joint's coordinate, what the elements that smooth it and that
/// truly stick have in common (H. Olsson et al., European Journal of Control 4 (1998) 176-195):
///
///     F = F_c + (F_s - F_c) exp(-(v / v_s)^2)      and beside it, in both, d v
struct FrictionLaw {
  double coulomb, static_force;  ///< F_c, F_s [N or N m]
  double stribeck_speed;         ///< v_s [m/s or rad/s]; 0: F_c at once
  double viscous;                ///< d [N s/m or N m s/rad]

  /// F at the speed v.
  double sliding(double v) const {
    if (stribeck_speed == 0.0) return coulomb;
    const double x = v / stribeck_speed;
    return coulomb + (static_force - coulomb) * std::exp(-x * x);
  }
  /// dF/dv.
  double sliding_slope(double v) const {
    if (stribeck_speed == 0.0) return 0.0;
    const double x = v / stribeck_speed;
    return -2.0 * x / stribeck_speed * (static_force - coulomb) * std::exp(-x * x);
  }
};

}  // namespace flexura::mbs
