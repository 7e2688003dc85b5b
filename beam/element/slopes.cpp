// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/element/slopes.hpp"

#include <Eigen/Geometry>

#include "beam/element/quadrature.hpp"

namespace flexura::beam {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

// Minus the gradient of the acceleration of load k: f(x + r) = f(x) + B r.
Matrix3d gradient(int k) {
  constexpr int kPairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  Matrix3d B = Matrix3d::Zero();
  if (k < 3) return B;
  if (k < 6) {  // -alpha x r
    const Vector3d e = Vector3d::Unit(k - 3);
    B << 0, e.z(), -e.y(), -e.z(), 0, e.x(), e.y(), -e.x(), 0;
    return B;
  }
  // -omega x (omega x r) = omega^2 r - omega (omega . r), each product counted once
  const auto [a, b] = kPairs[k - 6];
  B(a, b) -= 1.0;
  if (a == b) return B + Matrix3d::Identity();
  B(b, a) -= 1.0;
  return B;
}

}  // namespace

InertiaLoads inertia_loads(const Vector3d& x, double m, const Vector3d& s, const Matrix3d& E) {
  InertiaLoads out;
  for (int k = 0; k < out.cols(); ++k) {
    const Matrix3d B = gradient(k), BE = B * E;
    const Vector3d f = k < 3 ? Vector3d(-Vector3d::Unit(k)) : Vector3d(B * x);
    out.col(k) << m * f + B * s,
        s.cross(f) + Vector3d(BE(2, 1) - BE(1, 2), BE(0, 2) - BE(2, 0), BE(1, 0) - BE(0, 1));
  }
  return out;
}

InertiaLoads line_loads(const Placement& placement, double x, const SectionInertia& i) {
  const Matrix3d& R = placement.R_BE;
  Matrix3d E = Matrix3d::Zero();
  E.bottomRightCorner<2, 2>() << i.m_yy, i.m_yz, i.m_yz, i.m_zz;
  InertiaLoads loads = inertia_loads(placement.p_Bo1_B + x * R.col(0), i.m, R * Vector3d(0.0, i.m_y, i.m_z),
                                     R * E * R.transpose());
  loads.topRows<3>() = (R.transpose() * loads.topRows<3>()).eval();
  loads.bottomRows<3>() = (R.transpose() * loads.bottomRows<3>()).eval();
  return loads;
}

// The slopes are those of the cubic through the exact displacements at four places, so that released ends and shear
// deformation are in them.
std::array<SlopeStation, 4> slope_stations(const Element& element, double to) {
  const double l = element.length();
  std::array<double, 4> t;
  std::array<Matrix6x12d, 4> d;
  for (int j = 0; j < 4; ++j) {
    t[j] = j / 3.0;
    d[j] = element.shape(t[j] * l);
  }
  const auto rule = gauss_points(4);
  std::array<SlopeStation, 4> out;
  for (int g = 0; g < 4; ++g) {
    const double s = 0.5 * (1.0 + rule[g].first) * to / l;
    out[g] = {s * l, 0.5 * to * rule[g].second, Eigen::Matrix<double, 3, 12>::Zero()};
    for (int j = 0; j < 4; ++j) {  // derivative of Lagrange's polynomial j
      double slope = 0.0;
      for (int i = 0; i < 4; ++i) {
        if (i == j) continue;
        double term = 1.0 / (t[j] - t[i]);
        for (int m = 0; m < 4; ++m)
          if (m != i && m != j) term *= (s - t[m]) / (t[j] - t[m]);
        slope += term;
      }
      out[g].slopes += slope / l * d[j].middleRows<3>(1);
    }
  }
  return out;
}

}  // namespace flexura::beam
