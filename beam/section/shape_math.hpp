// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <numbers>

/// Small things that the formulas of shapes.cpp and shear_factors.cpp share.
namespace flexura::beam {

using std::numbers::pi;

template <class... Functions>
struct Overload : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overload(Functions...) -> Overload<Functions...>;

inline double pow2(double x) {
  return x * x;
}
inline double pow3(double x) {
  return x * x * x;
}
inline double pow4(double x) {
  return pow2(x * x);
}
inline double pow5(double x) {
  return pow4(x) * x;
}

/// The ellipse halfway between the contours of a hollow one, at phi = 2 pi k / n.
struct MidLine {
  struct Point {
    double y, z, t, ds;  // place, thickness across the mid-line, length of 1/n of the parameter
  };
  static constexpr int n = 1440;  // a multiple of 4; sums of smooth periodic functions converge to round-off
  double a, b, d_a, d_b;

  MidLine(double outer_a, double outer_b, double inner_a, double inner_b)
      : a(0.5 * (outer_a + inner_a)),
        b(0.5 * (outer_b + inner_b)),
        d_a(outer_a - inner_a),
        d_b(outer_b - inner_b) {}

  Point at(double k) const {
    const double phi = 2.0 * pi * k / n, c = std::cos(phi), s = std::sin(phi);
    const double speed = std::hypot(a * s, b * c);
    return {a * c, b * s, (d_a * b * c * c + d_b * a * s * s) / speed, speed * 2.0 * pi / n};
  }
};

}  // namespace flexura::beam
