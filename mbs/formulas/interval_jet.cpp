// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/interval_jet.hpp"

#include <numbers>

#include "mbs/formulas/operations.hpp"

namespace flexura::mbs {

using namespace operations;

IntervalJet operator+(const IntervalJet& a, const IntervalJet& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
IntervalJet operator-(const IntervalJet& a, const IntervalJet& b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second};
}
IntervalJet operator*(const IntervalJet& a, const IntervalJet& b) {
  if (is_constant(a)) return {a.value * b.value, a.value * b.first, a.value * b.second};
  if (is_constant(b)) return {a.value * b.value, a.first * b.value, a.second * b.value};
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + Interval(2.0) * a.first * b.first + a.value * b.second};
}
IntervalJet operator/(const IntervalJet& a, const IntervalJet& b) {
  if (is_constant(b)) return {a.value / b.value, a.first / b.value, a.second / b.value};
  IntervalJet c;
  c.value = a.value / b.value;
  c.first = (a.first - c.value * b.first) / b.value;
  c.second = (a.second - Interval(2.0) * c.first * b.first - c.value * b.second) / b.value;
  return c;
}
IntervalJet hull(const IntervalJet& a, const IntervalJet& b) {
  return {intervals::hull(a.value, b.value), intervals::hull(a.first, b.first),
          intervals::hull(a.second, b.second)};
}
IntervalJet chain(const IntervalJet& f, const IntervalJet& x) {
  return {f.value, f.first * x.first, f.second * square(x.first) + f.first * x.second};
}
bool is_constant(const IntervalJet& x) {
  return x.first.magnitude() == 0.0 && x.second.magnitude() == 0.0;
}

// The functions of operations.cpp that are smooth.
IntervalJet smooth_unary(int code, const Interval& x) {
  const Interval one = 1.0, two = 2.0;
  switch (code) {
    case minus:
      return {-x, -1.0, 0.0};
    case sine:
      return {sin(x), cos(x), -sin(x)};
    case cosine:
      return {cos(x), -sin(x), -cos(x)};
    case tangent: {
      const Interval f = tan(x), d = one + square(f);
      return {f, d, two * f * d};
    }
    case arc_sine:
    case arc_cosine: {
      const Interval d = one / sqrt(one - square(x)), d2 = x * d * d * d;
      if (code == arc_sine) return {asin(x), d, d2};
      return {acos(x), -d, -d2};
    }
    case arc_tangent: {
      const Interval d = one / (one + square(x));
      return {atan(x), d, -two * x * square(d)};
    }
    case operations::sinh:
      return {intervals::sinh(x), intervals::cosh(x), intervals::sinh(x)};
    case operations::cosh:
      return {intervals::cosh(x), intervals::sinh(x), intervals::cosh(x)};
    case operations::tanh: {
      const Interval f = intervals::tanh(x), d = one - square(f);
      return {f, d, -two * f * d};
    }
    case operations::asinh: {
      const Interval d = one / sqrt(one + square(x));
      return {intervals::asinh(x), d, -x * d * d * d};
    }
    case operations::acosh: {
      const Interval d = one / sqrt(square(x) - one);
      return {intervals::acosh(x), d, -x * d * d * d};
    }
    case operations::atanh: {
      const Interval d = one / (one - square(x));
      return {intervals::atanh(x), d, two * x * square(d)};
    }
    case exponential:
      return {exp(x), exp(x), exp(x)};
    case logarithm:
    case logarithm_10:
    case logarithm_2: {
      const Interval scale = code == logarithm      ? 1.0
                             : code == logarithm_10 ? 1.0 / std::numbers::ln10
                                                    : 1.0 / std::numbers::ln2;
      const Interval d = one / x;
      return {scale * log(x), scale * d, -scale * square(d)};
    }
    case square_root: {
      const Interval f = sqrt(x);
      return {f, Interval(0.5) / f, -Interval(0.25) / (f * x)};
    }
    default:
      return {x, 1.0, 0.0};
  }
}

}  // namespace flexura::mbs
