// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

#include "beam/exact/dual.hpp"

/// A rotation by its vector Theta, E = exp(Theta^), and how it turns.  With t = |Theta|^2 = theta^2
///
///     E     = 1 + a Theta^ + b Theta^ Theta^
///     omega = T Theta',   T = 1 - b Theta^ + c Theta^ Theta^         (in the axes of E)
///     a = sin(theta)/theta,   b = (1 - cos(theta))/t,   c = (1 - a)/t
///
/// (A. Cardona, M. Geradin, Int. J. Numer. Meth. Eng. 26 (1988) 2403).  Derivatives by t:
///
///     a' = (c - b)/2,   b' = (a - 2b)/(2t),   c' = (b - 3c)/(2t),   b'' = (a' - 4b')/(2t),   c'' = (b' - 5c')/(2t)
namespace flexura::beam::exact {

namespace series {
constexpr int kSize = 14;
/// (-1)^k / (first + 2k)!
constexpr std::array<double, kSize> inverse_factorials(int first) {
  std::array<double, kSize> out{};
  double factorial = 1.0;
  for (int k = 0, n = 0; k < kSize; ++k) {
    while (n < first + 2 * k) factorial *= ++n;
    out[static_cast<std::size_t>(k)] = (k % 2 == 0 ? 1.0 : -1.0) / factorial;
  }
  return out;
}
inline constexpr std::array<double, kSize> kB = inverse_factorials(2), kC = inverse_factorials(3);
}  // namespace series

struct RotationSeries {
  double b[3], c[3];  ///< with their first and second derivatives

  explicit RotationSeries(double t) {
    // b = sum (-t)^k/(2k+2)!, c = sum (-t)^k/(2k+3)!: the terms left out are below 1e-22, those of b'' below 1e-15.
    if (t < 4.0) {
      double p[3] = {}, q[3] = {};
      for (int k = t < 0.02 ? 6 : t < 0.25 ? 8 : series::kSize; k-- > 0;) {  // Horner, with derivatives
        p[2] = p[2] * t + 2.0 * p[1];
        p[1] = p[1] * t + p[0];
        p[0] = p[0] * t + series::kB[static_cast<std::size_t>(k)];
        q[2] = q[2] * t + 2.0 * q[1];
        q[1] = q[1] * t + q[0];
        q[0] = q[0] * t + series::kC[static_cast<std::size_t>(k)];
      }
      for (int i = 0; i < 3; ++i) {
        b[i] = p[i];
        c[i] = q[i];
      }
      return;
    }
    const double theta = std::sqrt(t), a = std::sin(theta) / theta;
    b[0] = (1.0 - std::cos(theta)) / t;
    c[0] = (1.0 - a) / t;
    const double a_1 = 0.5 * (c[0] - b[0]);
    b[1] = (a - 2.0 * b[0]) / (2.0 * t);
    c[1] = (b[0] - 3.0 * c[0]) / (2.0 * t);
    b[2] = (a_1 - 4.0 * b[1]) / (2.0 * t);
    c[2] = (b[1] - 5.0 * c[1]) / (2.0 * t);
  }
};

/// The rotation and its tangent map at Theta.
template <class S>
struct Rotation {
  Vec<S> Theta;
  S t, b, c, db, dc;  ///< db, dc: derivatives by t
  Mat<S> E;

  explicit Rotation(const Vec<S>& vector) : Theta(vector), t(dot(vector, vector)) {
    const RotationSeries f(value(t));
    b = chain(f.b[0], f.b[1], t);
    c = chain(f.c[0], f.c[1], t);
    db = chain(f.b[1], f.b[2], t);
    dc = chain(f.c[1], f.c[2], t);
    const S a = S(1.0) - t * c, cosine = S(1.0) - t * b;
    const Vec<S> bt = b * Theta, at = a * Theta;
    E.x = {cosine + bt.x * Theta.x, bt.x * Theta.y + at.z, bt.x * Theta.z - at.y};
    E.y = {bt.x * Theta.y - at.z, cosine + bt.y * Theta.y, bt.y * Theta.z + at.x};
    E.z = {bt.x * Theta.z + at.y, bt.y * Theta.z - at.x, cosine + bt.z * Theta.z};
  }
  /// T x.
  Vec<S> tangent(const Vec<S>& x) const {
    const Vec<S> X = cross(Theta, x);
    return x - b * X + c * cross(Theta, X);
  }
  /// T^T x.
  Vec<S> transposed_tangent(const Vec<S>& x) const {
    const Vec<S> X = cross(Theta, x);
    return x + b * X + c * cross(Theta, X);
  }
  /// T' rate, where Theta' = rate.
  Vec<S> bias(const Vec<S>& rate) const {
    const Vec<S> X = cross(Theta, rate);
    const S t_dot = 2.0 * dot(Theta, rate);
    return c * cross(rate, X) + t_dot * (dc * cross(Theta, X) - db * X);
  }
};

}  // namespace flexura::beam::exact
