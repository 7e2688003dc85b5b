// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace flexura::extremes {

/// x'' + 2 zeta omega x' + omega^2 x = 0 from x = a at rest.
inline double damped_vibration(double omega, double zeta, double a, double t) {
  const double decay = std::exp(-zeta * omega * t);
  if (zeta < 1.0) {
    const double w = omega * std::sqrt(1.0 - zeta * zeta);
    return a * decay * (std::cos(w * t) + zeta * omega / w * std::sin(w * t));
  }
  if (zeta == 1.0) return a * decay * (1.0 + omega * t);
  // The sum of two decays; the slow one alone where the other has gone (no cosh of what overflows).
  const double w = omega * std::sqrt(zeta * zeta - 1.0), slow = omega * omega / (zeta * omega + w),
               fast = zeta * omega + w;
  return a * (fast * std::exp(-slow * t) - slow * std::exp(-fast * t)) / (fast - slow);
}

}  // namespace flexura::extremes
