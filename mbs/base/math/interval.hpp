// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

/// Interval arithmetic: every operation returns an interval that holds all results for arguments from its
/// operands (R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, 2009), up to
/// round-off: bounds are not rounded outwards, a caller who compares them leaves room for a few ulp.  What is
/// not defined somewhere in its operands is `everywhere`.
namespace flexura::mbs::intervals {

struct Interval {
  double lo = 0.0, hi = 0.0;

  constexpr Interval() = default;
  constexpr Interval(double x) : lo(x), hi(x) {}  // NOLINT: numbers are intervals
  constexpr Interval(double a, double b) : lo(a), hi(b) {}
  static Interval everywhere() {
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  }
  /// From two bounds that may be undefined.
  static Interval of(double a, double b) { return a <= b ? Interval(a, b) : everywhere(); }

  double width() const { return hi - lo; }
  double magnitude() const { return std::max(std::abs(lo), std::abs(hi)); }
  bool contains(double x) const { return lo <= x && x <= hi; }
  bool is_finite() const { return std::isfinite(lo) && std::isfinite(hi); }
};

inline Interval hull(const Interval& a, const Interval& b) {
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}
inline Interval operator+(const Interval& a, const Interval& b) {
  return Interval::of(a.lo + b.lo, a.hi + b.hi);
}
inline Interval operator-(const Interval& a, const Interval& b) {
  return Interval::of(a.lo - b.hi, a.hi - b.lo);
}
inline Interval operator-(const Interval& a) {
  return {-a.hi, -a.lo};
}
inline Interval operator*(const Interval& a, const Interval& b) {
  const double ll = a.lo * b.lo, lh = a.lo * b.hi, hl = a.hi * b.lo, hh = a.hi * b.hi;
  if (std::isfinite(ll + lh + hl + hh)) return {std::min({ll, lh, hl, hh}), std::max({ll, lh, hl, hh})};
  // 0 times a bound that is infinite is 0: it stands for numbers however large, not for infinity.
  const auto times = [](double x, double y) { return x == 0.0 || y == 0.0 ? 0.0 : x * y; };
  const double p[] = {times(a.lo, b.lo), times(a.lo, b.hi), times(a.hi, b.lo), times(a.hi, b.hi)};
  return Interval::of(*std::min_element(p, p + 4), *std::max_element(p, p + 4));
}
inline Interval operator/(const Interval& a, const Interval& b) {
  if (b.contains(0.0)) return a.lo == 0.0 && a.hi == 0.0 ? Interval(0.0) : Interval::everywhere();
  return a * Interval::of(1.0 / b.hi, 1.0 / b.lo);
}

inline Interval square(const Interval& x) {
  const double a = x.lo * x.lo, b = x.hi * x.hi;
  return {x.contains(0.0) ? 0.0 : std::min(a, b), std::max(a, b)};
}
/// x^n for any constant n; of a broken n only x >= 0 counts.
inline Interval pow(const Interval& x, double n) {
  if (n == 0.0) return 1.0;
  if (n == std::rint(n)) {
    const bool even = std::fmod(n, 2.0) == 0.0;
    if (n < 0.0 && x.contains(0.0)) return Interval::everywhere();
    const double a = std::pow(x.lo, n), b = std::pow(x.hi, n);
    if (even && x.contains(0.0)) return Interval::of(0.0, std::max(a, b));
    return Interval::of(std::min(a, b), std::max(a, b));
  }
  if (x.hi < 0.0 || (n < 0.0 && x.lo <= 0.0)) return Interval::everywhere();
  const double a = std::pow(std::max(x.lo, 0.0), n), b = std::pow(x.hi, n);
  return Interval::of(std::min(a, b), std::max(a, b));
}

/// Of functions that rise, or are not defined.
template <class F>
Interval rising(const Interval& x, F&& f) {
  return Interval::of(f(x.lo), f(x.hi));
}
inline Interval exp(const Interval& x) {
  return rising(x, [](double u) { return std::exp(u); });
}
inline Interval sqrt(const Interval& x) {
  if (x.hi < 0.0) return Interval::everywhere();
  return {std::sqrt(std::max(0.0, x.lo)), std::sqrt(x.hi)};
}
inline Interval log(const Interval& x) {
  if (x.hi <= 0.0) return Interval::everywhere();
  return {x.lo > 0.0 ? std::log(x.lo) : -std::numeric_limits<double>::infinity(), std::log(x.hi)};
}
inline Interval sin(const Interval& x) {
  if (!(x.width() < 2.0 * std::numbers::pi)) return {-1.0, 1.0};
  const double a = std::sin(x.lo), b = std::sin(x.hi);
  const auto holds = [&](double phase) {
    constexpr double turn = 2.0 * std::numbers::pi;
    return std::ceil((x.lo - phase) / turn) * turn + phase <= x.hi;
  };
  return {holds(-0.5 * std::numbers::pi) ? -1.0 : std::min(a, b),
          holds(0.5 * std::numbers::pi) ? 1.0 : std::max(a, b)};
}
inline Interval cos(const Interval& x) {
  return sin(x + Interval(0.5 * std::numbers::pi));
}
inline Interval tan(const Interval& x) {
  constexpr double half = 0.5 * std::numbers::pi;
  // Between two poles.
  if (!(x.width() < std::numbers::pi) ||
      std::floor((x.lo + half) / std::numbers::pi) != std::floor((x.hi + half) / std::numbers::pi))
    return Interval::everywhere();
  return rising(x, [](double u) { return std::tan(u); });
}
inline Interval asin(const Interval& x) {
  return rising(x, [](double u) { return std::asin(u); });
}
inline Interval acos(const Interval& x) {
  return Interval::of(std::acos(x.hi), std::acos(x.lo));
}
inline Interval atan(const Interval& x) {
  return {std::atan(x.lo), std::atan(x.hi)};
}
inline Interval sinh(const Interval& x) {
  return rising(x, [](double u) { return std::sinh(u); });
}
inline Interval cosh(const Interval& x) {
  const double a = std::cosh(x.lo), b = std::cosh(x.hi);
  return {x.contains(0.0) ? 1.0 : std::min(a, b), std::max(a, b)};
}
inline Interval tanh(const Interval& x) {
  return {std::tanh(x.lo), std::tanh(x.hi)};
}
inline Interval asinh(const Interval& x) {
  return {std::asinh(x.lo), std::asinh(x.hi)};
}
inline Interval acosh(const Interval& x) {
  return rising(x, [](double u) { return std::acosh(u); });
}
inline Interval atanh(const Interval& x) {
  return rising(x, [](double u) { return std::atanh(u); });
}

}  // namespace flexura::mbs::intervals

namespace flexura::mbs {
using intervals::hull;
using intervals::Interval;
}  // namespace flexura::mbs
