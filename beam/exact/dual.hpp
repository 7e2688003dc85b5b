// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>

/// Numbers that carry their first derivatives by N variables, and vectors of them: functions written for any number
/// differentiate themselves, to round-off.
namespace flexura::beam::exact {

template <int N>
struct Dual {
  double v = 0.0;
  std::array<double, N> d{};

  Dual() = default;
  Dual(double value) : v(value) {}  // NOLINT: a constant is a number without derivatives
  /// Variable i.
  static Dual variable(double value, int i) {
    Dual x(value);
    x.d[static_cast<std::size_t>(i)] = 1.0;
    return x;
  }

  Dual& operator+=(const Dual& b) {
    v += b.v;
    for (std::size_t i = 0; i < N; ++i) d[i] += b.d[i];
    return *this;
  }
  Dual& operator-=(const Dual& b) {
    v -= b.v;
    for (std::size_t i = 0; i < N; ++i) d[i] -= b.d[i];
    return *this;
  }
  friend Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend Dual operator-(const Dual& a) {
    Dual out(-a.v);
    for (std::size_t i = 0; i < N; ++i) out.d[i] = -a.d[i];
    return out;
  }
  friend Dual operator*(const Dual& a, const Dual& b) {
    Dual out(a.v * b.v);
    for (std::size_t i = 0; i < N; ++i) out.d[i] = a.v * b.d[i] + b.v * a.d[i];
    return out;
  }
  friend Dual operator*(double a, const Dual& b) {
    Dual out(a * b.v);
    for (std::size_t i = 0; i < N; ++i) out.d[i] = a * b.d[i];
    return out;
  }
  friend Dual operator*(const Dual& a, double b) { return b * a; }
};

inline double value(double x) {
  return x;
}
template <int N>
double value(const Dual<N>& x) {
  return x.v;
}

/// f(x) from f and f' at the value of x.
inline double chain(double f, double, double) {
  return f;
}
template <int N>
Dual<N> chain(double f, double df, const Dual<N>& x) {
  Dual<N> out(f);
  for (std::size_t i = 0; i < N; ++i) out.d[i] = df * x.d[i];
  return out;
}

template <class S>
struct Vec {
  S x = 0.0, y = 0.0, z = 0.0;

  Vec& operator+=(const Vec& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
  friend Vec operator+(Vec a, const Vec& b) { return a += b; }
  friend Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
};
template <class S>
Vec<S> operator*(const S& a, const Vec<S>& b) {
  return {a * b.x, a * b.y, a * b.z};
}
template <class S>
requires(!std::is_same_v<S, double>) Vec<S>
operator*(double a, const Vec<S>& b) {
  return {a * b.x, a * b.y, a * b.z};
}
template <class S>
S dot(const Vec<S>& a, const Vec<S>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class S>
Vec<S> cross(const Vec<S>& a, const Vec<S>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// A rotation by its columns.
template <class S>
struct Mat {
  Vec<S> x, y, z;

  Vec<S> operator*(const Vec<S>& a) const { return a.x * x + a.y * y + a.z * z; }
  Vec<S> transposed(const Vec<S>& a) const { return {dot(x, a), dot(y, a), dot(z, a)}; }
};

}  // namespace flexura::beam::exact
