// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// Numbers that carry their gradient with respect to three coordinates: shape functions are written once and
/// differentiated exactly (forward automatic differentiation).
namespace flexura::mesh {

struct Dual {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();

  Dual() = default;
  explicit Dual(double v) : value(v) {}
  Dual(double v, const Eigen::Vector3d& g) : value(v), gradient(g) {}
  static Dual variable(double v, int direction) { return {v, Eigen::Vector3d::Unit(direction)}; }

  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.gradient + b.gradient}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.gradient - b.gradient}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.gradient * b.value + a.value * b.gradient};
  }
  friend Dual operator/(const Dual& a, const Dual& b) {
    return {a.value / b.value, (a.gradient - a.value / b.value * b.gradient) / b.value};
  }
  friend Dual operator+(const Dual& a, double b) { return {a.value + b, a.gradient}; }
  friend Dual operator+(double a, const Dual& b) { return b + a; }
  friend Dual operator-(const Dual& a, double b) { return {a.value - b, a.gradient}; }
  friend Dual operator-(double a, const Dual& b) { return {a - b.value, -b.gradient}; }
  friend Dual operator*(double a, const Dual& b) { return {a * b.value, a * b.gradient}; }
  friend Dual operator*(const Dual& a, double b) { return b * a; }
};

}  // namespace flexura::mesh
