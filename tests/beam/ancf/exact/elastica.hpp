// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Inextensible cantilever under a dead tip load normal to its rest axis (K. E. Bisshopp, D. C. Drucker, Q.
/// Appl. Math. 3 (1945) 272).  With alpha = P L^2/(E I), the tip angle theta and k^2 = (1 + sin theta)/2, sin
/// phi = 1/(k sqrt 2):
///
///     sqrt(alpha) = K(k) - F(phi, k)
///     deflection/L = 1 - 2 (E(k) - E(phi, k))/sqrt(alpha),   1 - shortening/L = sqrt(2 sin theta / alpha)
namespace flexura::beam::exact {

struct Elastica {
  double tip_angle = 0.0;   ///< [rad]
  double deflection = 0.0;  ///< of the tip along the load, over L
  double shortening = 0.0;  ///< of the tip's projection on the rest axis, over L
};

/// alpha > 0.
Elastica elastica_tip_load(double alpha);

}  // namespace flexura::beam::exact
