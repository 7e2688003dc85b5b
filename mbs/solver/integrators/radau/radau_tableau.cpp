// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/radau/radau_tableau.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace flexura::mbs {

RadauTableau::RadauTableau() {
  const double r = std::sqrt(6.0);
  c = {(4.0 - r) / 10.0, (4.0 + r) / 10.0, 1.0};
  Eigen::Matrix3d A;
  A << (88.0 - 7.0 * r) / 360.0, (296.0 - 169.0 * r) / 1800.0, (-2.0 + 3.0 * r) / 225.0,
      (296.0 + 169.0 * r) / 1800.0, (88.0 + 7.0 * r) / 360.0, (-2.0 - 3.0 * r) / 225.0, (16.0 - r) / 36.0,
      (16.0 + r) / 36.0, 1.0 / 9.0;
  B = A.inverse();
  // The characteristic polynomial of B is x^3 - 9 x^2 + 36 x - 60.
  const double a = std::cbrt(3.0), b = a * a;
  gamma = 3.0 + b - a;
  lambda = {0.5 * (9.0 - gamma), 0.5 * std::sqrt(3.0) * (b + a)};
  take_eigenvectors();
  e = {-(13.0 + 7.0 * r) / 3.0, (-13.0 + 7.0 * r) / 3.0, -1.0 / 3.0};
}

GaussTableau::GaussTableau() {
  const double r = std::sqrt(15.0);
  c = {0.5 - r / 10.0, 0.5, 0.5 + r / 10.0};
  Eigen::Matrix3d A;
  A << 5.0 / 36.0, 2.0 / 9.0 - r / 15.0, 5.0 / 36.0 - r / 30.0, 5.0 / 36.0 + r / 24.0, 2.0 / 9.0,
      5.0 / 36.0 - r / 24.0, 5.0 / 36.0 + r / 30.0, 2.0 / 9.0 + r / 15.0, 5.0 / 36.0;
  B = A.inverse();
  // The characteristic polynomial of B is x^3 - 12 x^2 + 60 x - 120; with x = y + 4, y^3 + 12 y - 8.
  const double a = std::cbrt(4.0 + std::sqrt(80.0)), b = std::cbrt(std::sqrt(80.0) - 4.0);
  gamma = 4.0 + a - b;
  lambda = {0.5 * (12.0 - gamma), 0.5 * std::sqrt(3.0) * (a + b)};
  take_eigenvectors();
}

void ThreeStages::take_eigenvectors() {
  // Perpendicular to two rows of B - x 1.
  const Eigen::Matrix3d R = B - gamma * Eigen::Matrix3d::Identity();
  v = Eigen::Vector3d(R.row(0)).cross(Eigen::Vector3d(R.row(1))).normalized();
  const Eigen::Matrix3cd C = B.cast<std::complex<double>>() - lambda * Eigen::Matrix3cd::Identity();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    w(i) = C(0, j) * C(1, k) - C(0, k) * C(1, j);
  }
  w.normalize();
  Eigen::Matrix3cd V;
  V << v.cast<std::complex<double>>(), w, w.conjugate();
  const Eigen::Matrix3cd inverse = V.inverse();
  v_left = inverse.row(0).real();
  w_left = inverse.row(1);
}

double ThreeStages::basis(int i, double x) const {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  return x * (x - c[j]) * (x - c[k]) / (c[i] * (c[i] - c[j]) * (c[i] - c[k]));
}

double ThreeStages::slope(int i, double x) const {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  return ((x - c[j]) * (x - c[k]) + x * (x - c[k]) + x * (x - c[j])) / (c[i] * (c[i] - c[j]) * (c[i] - c[k]));
}

void RadauPolynomial::value(double x, Eigen::VectorXd& y) const {
  y = y_begin;
  for (int i = 0; i < 3; ++i) y += tableau.basis(i, x) * Z[i];
}

}  // namespace flexura::mbs
