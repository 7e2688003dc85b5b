// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace flexura::mbs {

/// The pressure between two surfaces where one has gone into the other by delta, at the rate u [m, m/s]:
///
///     p = k delta^n max(0, 1 + c u),     delta > 0
///
/// (Hunt and Crossley's damping, J. Appl. Mech. 42 (1975) 440-445, over an area: it starts from nothing with the penetration,
/// so that nothing jumps where a node touches, and it never pulls).  What is stored is k delta^(n + 1) / (n + 1) per area.
class PressureLaw {
 public:
  /// k [Pa / m^n] > 0, n >= 1, c >= 0 [s/m].
  PressureLaw(double k, double n, double c) : k_(k), n_(n), c_(c) {}

  struct Value {
    double p = 0.0;                        ///< [Pa]
    double by_depth = 0.0, by_rate = 0.0;  ///< its derivatives
    double elastic = 0.0;                  ///< k delta^n
    double energy = 0.0;                   ///< [J / m^2]
  };
  Value at(double depth, double rate) const {
    Value v;
    if (!(depth > 0.0)) return v;
    const double damped = 1.0 + c_ * rate, slope = n_ == 1.0 ? k_ : k_ * std::pow(depth, n_ - 1.0);
    v.elastic = slope * depth;
    v.energy = v.elastic * depth / (n_ + 1.0);
    if (!(damped > 0.0)) return v;
    v.p = v.elastic * damped;
    v.by_depth = n_ * slope * damped;
    v.by_rate = v.elastic * c_;
    return v;
  }

 private:
  double k_, n_, c_;
};

}  // namespace flexura::mbs
