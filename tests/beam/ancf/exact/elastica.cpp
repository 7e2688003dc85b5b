// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/beam/ancf/exact/elastica.hpp"

#include <cmath>

namespace flexura::beam::exact {

Elastica elastica_tip_load(double alpha) {
  const auto modulus = [](double theta) { return std::sqrt(0.5 * (1 + std::sin(theta))); };
  const auto amplitude = [](double k) { return std::asin(1 / (k * M_SQRT2)); };
  // sqrt(alpha) grows with the tip angle from 0 to infinity at 90 degrees: bisection to the last bit.
  double low = 0.0, high = M_PI / 2;
  for (int i = 0; i < 100; ++i) {
    const double theta = 0.5 * (low + high), k = modulus(theta);
    const bool below = std::comp_ellint_1(k) - std::ellint_1(k, amplitude(k)) < std::sqrt(alpha);
    (below ? low : high) = theta;
  }
  const double theta = low, k = modulus(theta);
  return {theta, 1 - 2 * (std::comp_ellint_2(k) - std::ellint_2(k, amplitude(k))) / std::sqrt(alpha),
          1 - std::sqrt(2 * std::sin(theta) / alpha)};
}

}  // namespace flexura::beam::exact
