// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <type_traits>

#include "mbs/formulas/expression.hpp"

/// The operations of a formula's program, on plain numbers and on jets (value, d/dt, d^2/dt^2).
///
///   (f g)'' = f'' g + 2 f' g' + f g'',   f(x(t))'' = f''(x) x'^2 + f'(x) x''
namespace flexura::mbs::operations {

/// What an instruction does.
enum Code : int {
  // operators and flow
  constant,
  signal,
  add,
  subtract,
  multiply,
  divide,
  power,
  less,
  less_equal,
  greater,
  greater_equal,
  equal,
  not_equal,
  logical_and,
  logical_or,
  jump_if_zero,
  jump,
  // functions of one argument
  plus,
  minus,
  sine,
  cosine,
  tangent,
  arc_sine,
  arc_cosine,
  arc_tangent,
  sinh,
  cosh,
  tanh,
  asinh,
  acosh,
  atanh,
  exponential,
  logarithm,
  logarithm_10,
  logarithm_2,
  square_root,
  absolute,
  signum,
  round_to_integer,
  round_down,
  round_up,
  table,
  // of more
  arc_tangent_2,
  minimum,
  maximum,
  modulo,
  smooth_step,
  // of a formula's tree only
  choice
};

Jet operator+(const Jet& a, const Jet& b);
Jet operator-(const Jet& a, const Jet& b);
Jet operator*(const Jet& a, const Jet& b);
Jet operator/(const Jet& a, const Jet& b);

inline double value_of(double x) {
  return x;
}
inline double value_of(const Jet& x) {
  return x.value;
}

/// Of a comparison but that of equals, a sign and what rounds: the value jumps where what it looks at passes an edge.
inline bool jumps(int code) {
  switch (code) {
    case less:
    case less_equal:
    case greater:
    case greater_equal:
    case signum:
    case round_to_integer:
    case round_down:
    case round_up:
    case modulo:
      return true;
    default:
      return false;
  }
}

/// A function of one argument.
double apply_unary(int code, double x);
Jet apply_unary(int code, const Jet& x);

double power_of(double x, double y);
Jet power_of(const Jet& x, const Jet& y);

double arc_tangent_2_of(double y, double x);
Jet arc_tangent_2_of(const Jet& y, const Jet& x);

double table_of(const Curve& curve, double x);
Jet table_of(const Curve& curve, const Jet& x);

/// What is left of x after whole multiples of y: of the sign of y.
inline double modulo_of(double x, double y) {
  return x - y * std::floor(x / y);
}
Jet modulo_of(const Jet& x, const Jet& y);

template <class T>
T constant_of(double x) {
  if constexpr (std::is_same_v<T, Jet>)
    return Jet{x, 0.0, 0.0};
  else
    return x;
}

/// The cubic from y0 at x0 to y1 at x1, level outside.
template <class T>
T smooth_step_of(const T& x, const T& x0, const T& y0, const T& x1, const T& y1) {
  if (value_of(x) <= value_of(x0)) return y0;
  if (value_of(x) >= value_of(x1)) return y1;
  const T u = (x - x0) / (x1 - x0);
  return y0 + (y1 - y0) * u * u * (constant_of<T>(3.0) - constant_of<T>(2.0) * u);
}

}  // namespace flexura::mbs::operations
