// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

/// Gauss' four points and weights on [0, 1], and the polynomials through the points.
namespace flexura::beam::exact::gauss {

inline constexpr std::array<double, 4> kAt = {0.06943184420297371239, 0.33000947820757186760,
                                              0.66999052179242813240, 0.93056815579702628761};
inline constexpr std::array<double, 4> kWeight = {0.17392742256872692869, 0.32607257743127307131,
                                                  0.32607257743127307131, 0.17392742256872692869};

/// int_0^z of the polynomial that is 1 at point h and 0 at the others.
inline double polynomial_integral(std::size_t h, double z) {
  double p[4] = {1.0, 0.0, 0.0, 0.0};  // coefficients, by ascending power
  int degree = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    if (k == h) continue;
    const double scale = 1.0 / (kAt[h] - kAt[k]);
    ++degree;
    for (int i = degree; i >= 0; --i)
      p[i] = scale * ((i > 0 ? p[i - 1] : 0.0) - (i < degree ? kAt[k] * p[i] : 0.0));
  }
  double sum = 0.0;
  for (int i = 3; i >= 0; --i) sum = (sum + p[i] / (i + 1)) * z;
  return sum;
}

}  // namespace flexura::beam::exact::gauss
