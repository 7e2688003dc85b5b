// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace flexura::beam {

/// Gauss-Legendre points and weights on (-1, 1), by Newton's method on the Legendre polynomial; exact to
/// degree 2 n - 1.
inline std::vector<std::pair<double, double>> gauss_points(int n) {
  std::vector<std::pair<double, double>> rule(n);
  for (int k = 0; k < n; ++k) {
    double x = std::cos(std::numbers::pi * (k + 0.75) / (n + 0.5)), slope = 0.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double p = 1.0, previous = 0.0;
      for (int j = 1; j <= n; ++j) {
        const double next = ((2.0 * j - 1.0) * x * p - (j - 1.0) * previous) / j;
        previous = p;
        p = next;
      }
      slope = n * (x * p - previous) / (x * x - 1.0);
      const double step = p / slope;
      x -= step;
      if (std::abs(step) < 1e-16) break;
    }
    rule[k] = {x, 2.0 / ((1.0 - x * x) * slope * slope)};
  }
  return rule;
}

}  // namespace flexura::beam
