// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>

/// Shape functions of the axis and quadrature rules of the absolute nodal coordinate formulation.
///
/// Cubic Hermite functions over an element of length l, xi = x/l in [0, 1], in the order (r_A, r_x,A, r_B,
/// r_x,B) (A. A. Shabana, Dynamics of Multibody Systems, ch. 7):
///
///     S1 = 1 - 3 xi^2 + 2 xi^3   S2 = l (xi - 2 xi^2 + xi^3)   S3 = 3 xi^2 - 2 xi^3   S4 = l (-xi^2 + xi^3)
namespace flexura::beam::ancf {

using Shapes = Eigen::RowVector4d;

/// S at xi.
inline Shapes hermite(double xi, double l) {
  const double xi2 = xi * xi, xi3 = xi2 * xi;
  return {1 - 3 * xi2 + 2 * xi3, l * (xi - 2 * xi2 + xi3), 3 * xi2 - 2 * xi3, l * (xi3 - xi2)};
}

/// dS/dx.
inline Shapes hermite_x(double xi, double l) {
  const double xi2 = xi * xi;
  return {6 * (xi2 - xi) / l, 1 - 4 * xi + 3 * xi2, 6 * (xi - xi2) / l, 3 * xi2 - 2 * xi};
}

/// d2S/dx2.
inline Shapes hermite_xx(double xi, double l) {
  return {(12 * xi - 6) / (l * l), (6 * xi - 4) / l, (6 - 12 * xi) / (l * l), (6 * xi - 2) / l};
}

struct QuadraturePoint {
  double xi;      ///< in [0, 1]
  double weight;  ///< the weights of a rule sum to 1
};

/// Gauss rule with n = 1 ... 5 points on [0, 1], exact for polynomials of degree 2n - 1.  Throws
/// std::invalid_argument for another n.
std::span<const QuadraturePoint> gauss_rule(int n);

/// Lobatto rule with three points (Simpson's): both ends and the middle, exact for polynomials of degree 3.
std::span<const QuadraturePoint> lobatto_rule();

}  // namespace flexura::beam::ancf
