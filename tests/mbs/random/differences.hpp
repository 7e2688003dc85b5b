// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// Differences of order four: with values up to 1, derivatives grow by 1 / h's scale; errors 1e-13 and 1e-9.
namespace flexura::mbs::chance {

constexpr double kFirst = 1e-3, kSecond = 3e-3;

template <class F>
Eigen::VectorXd first_difference(F&& f, double h) {
  return (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
}

template <class F>
Eigen::VectorXd second_difference(F&& f, double h) {
  return (16.0 * (f(h) + f(-h)) - (f(2.0 * h) + f(-2.0 * h)) - 30.0 * f(0.0)) / (12.0 * h * h);
}

/// Of one number.
template <class F>
double slope(F&& f, double h) {
  return (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h);
}

}  // namespace flexura::mbs::chance
