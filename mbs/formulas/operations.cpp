// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/operations.hpp"

#include <cmath>
#include <numbers>

namespace flexura::mbs::operations {
namespace {

/// f, f', f'' of a function of one argument.
Jet unary(int code, double x) {
  switch (code) {
    case plus:
      return {x, 1, 0};
    case minus:
      return {-x, -1, 0};
    case sine:
      return {std::sin(x), std::cos(x), -std::sin(x)};
    case cosine:
      return {std::cos(x), -std::sin(x), -std::cos(x)};
    case tangent: {
      const double f = std::tan(x), d = 1 + f * f;
      return {f, d, 2 * f * d};
    }
    case arc_sine: {
      const double d = 1 / std::sqrt(1 - x * x);
      return {std::asin(x), d, x * d * d * d};
    }
    case arc_cosine: {
      const double d = 1 / std::sqrt(1 - x * x);
      return {std::acos(x), -d, -x * d * d * d};
    }
    case arc_tangent: {
      const double d = 1 / (1 + x * x);
      return {std::atan(x), d, -2 * x * d * d};
    }
    case sinh:
      return {std::sinh(x), std::cosh(x), std::sinh(x)};
    case cosh:
      return {std::cosh(x), std::sinh(x), std::cosh(x)};
    case tanh: {
      const double f = std::tanh(x), d = 1 - f * f;
      return {f, d, -2 * f * d};
    }
    case asinh: {
      const double d = 1 / std::sqrt(x * x + 1);
      return {std::asinh(x), d, -x * d * d * d};
    }
    case acosh: {
      const double d = 1 / std::sqrt(x * x - 1);
      return {std::acosh(x), d, -x * d * d * d};
    }
    case atanh: {
      const double d = 1 / (1 - x * x);
      return {std::atanh(x), d, 2 * x * d * d};
    }
    case exponential:
      return {std::exp(x), std::exp(x), std::exp(x)};
    case logarithm:
      return {std::log(x), 1 / x, -1 / (x * x)};
    case logarithm_10:
      return {std::log10(x), 1 / (x * std::numbers::ln10), -1 / (x * x * std::numbers::ln10)};
    case logarithm_2:
      return {std::log2(x), 1 / (x * std::numbers::ln2), -1 / (x * x * std::numbers::ln2)};
    case square_root: {
      const double f = std::sqrt(x);
      return {f, 0.5 / f, -0.25 / (f * x)};
    }
    case absolute:
      return {std::abs(x), x < 0 ? -1.0 : 1.0, 0};
    case signum:
      return {x > 0 ? 1.0 : x < 0 ? -1.0 : 0.0, 0, 0};
    case round_down:
      return {std::floor(x), 0, 0};
    case round_up:
      return {std::ceil(x), 0, 0};
    default:
      return {std::rint(x), 0, 0};
  }
}

}  // namespace

Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
Jet operator-(const Jet& a, const Jet& b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second};
}
Jet operator*(const Jet& a, const Jet& b) {
  return {a.value * b.value, a.first * b.value + a.value * b.first,
          a.second * b.value + 2.0 * a.first * b.first + a.value * b.second};
}
Jet operator/(const Jet& a, const Jet& b) {
  Jet c;
  c.value = a.value / b.value;
  c.first = (a.first - c.value * b.first) / b.value;
  c.second = (a.second - 2.0 * c.first * b.first - c.value * b.second) / b.value;
  return c;
}

double apply_unary(int code, double x) {
  return unary(code, x).value;
}
Jet apply_unary(int code, const Jet& x) {
  const Jet f = unary(code, x.value);
  // A constant argument stays constant where f' is infinite (sqrt(0)).
  const auto term = [](double a, double b) { return b == 0.0 ? 0.0 : a * b; };
  return {f.value, term(f.first, x.first), term(f.second, x.first * x.first) + term(f.first, x.second)};
}

double power_of(double x, double y) {
  return std::pow(x, y);
}
Jet power_of(const Jet& x, const Jet& y) {
  if (y.first == 0.0 && y.second == 0.0) {
    const double n = y.value;
    const auto term = [&](double factor, double exponent, double by) {
      return factor == 0.0 || by == 0.0 ? 0.0 : factor * std::pow(x.value, exponent) * by;
    };
    return {std::pow(x.value, n), term(n, n - 1, x.first),
            term(n * (n - 1), n - 2, x.first * x.first) + term(n, n - 1, x.second)};
  }
  return apply_unary(exponential, y * apply_unary(logarithm, x));
}

double arc_tangent_2_of(double y, double x) {
  return std::atan2(y, x);
}
Jet arc_tangent_2_of(const Jet& y, const Jet& x) {
  const double r2 = x.value * x.value + y.value * y.value;
  Jet f;
  f.value = std::atan2(y.value, x.value);
  f.first = (x.value * y.first - y.value * x.first) / r2;
  f.second =
      (x.value * y.second - y.value * x.second - 2.0 * (x.value * x.first + y.value * y.first) * f.first) /
      r2;
  return f;
}

Jet modulo_of(const Jet& x, const Jet& y) {
  const double n = std::floor(x.value / y.value);
  return {x.value - n * y.value, x.first - n * y.first, x.second - n * y.second};
}

double table_of(const Curve& curve, double x) {
  return curve(x);
}
Jet table_of(const Curve& curve, const Jet& x) {
  const Curve::Value f = curve.at(x.value);
  return {f.value, f.first * x.first, f.second * x.first * x.first + f.first * x.second};
}

}  // namespace flexura::mbs::operations
