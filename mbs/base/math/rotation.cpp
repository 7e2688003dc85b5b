// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/math/rotation.hpp"

#include <cmath>
#include <stdexcept>

namespace flexura::mbs {
namespace {

/// s = sin(phi)/phi, a = (1 - cos phi)/phi^2, b = (phi - sin phi)/phi^3 and the derivatives of a, b by x =
/// phi^2.
struct Coefficients {
  double s, a, b, da, db;
};

Coefficients coefficients(double x) {
  Coefficients c;
  if (x < 0.25) {
    // Power series in x: with 8 terms the first one left out is below 0.25^8 / 18! = 3e-21.
    double term_a = 0.5, term_b = 1.0 / 6.0;  // (-x)^k / (2k+2)! and (-x)^k / (2k+3)!
    c.a = c.b = c.da = c.db = 0.0;
    // The small rotations of a deformed body need two terms: the rest is below round-off.
    double power = 1.0;
    for (int k = 0; k < 8 && power > 1e-18; ++k, power *= x) {
      c.a += term_a;
      c.b += term_b;
      const double next_a = -term_a / ((2 * k + 3) * (2 * k + 4));  // without its factor x
      const double next_b = -term_b / ((2 * k + 4) * (2 * k + 5));
      c.da += (k + 1) * next_a;
      c.db += (k + 1) * next_b;
      term_a = next_a * x;
      term_b = next_b * x;
    }
    c.s = 1.0 - x * c.b;
    return c;
  }
  const double phi = std::sqrt(x), cosine = std::cos(phi);
  c.s = std::sin(phi) / phi;
  c.a = (1.0 - cosine) / x;
  c.b = (1.0 - c.s) / x;
  c.da = (0.5 * c.s - c.a) / x;
  c.db = (-0.5 * (cosine - c.s) / x - c.b) / x;
  return c;
}

Eigen::Vector4d product(const Eigen::Vector4d& p, const Eigen::Vector4d& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
          p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
          p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]};
}

}  // namespace

Matrix3d rotation_exp(const Vector3d& theta) {
  const Coefficients c = coefficients(theta.squaredNorm());
  const Matrix3d S = skew(theta);
  return Matrix3d::Identity() + c.s * S + c.a * S * S;
}

Vector3d rotation_log(const Matrix3d& R) {
  const Eigen::Vector4d q = quaternion_of_rotation(R);
  const Vector3d axis = q.tail<3>();
  const double sine = axis.norm();
  // atan2 is exact to round-off for all angles; the quotient tends to 2 as the angle vanishes.
  return sine < 1e-150 ? Vector3d(2.0 * axis) : Vector3d(2.0 * std::atan2(sine, q[0]) / sine * axis);
}

Matrix3d left_jacobian(const Vector3d& theta) {
  const Coefficients c = coefficients(theta.squaredNorm());
  const Matrix3d S = skew(theta);
  return Matrix3d::Identity() + c.a * S + c.b * S * S;
}

Vector3d left_jacobian_bias(const Vector3d& theta, const Vector3d& theta_dot) {
  const Coefficients c = coefficients(theta.squaredNorm());
  const double x_dot = 2.0 * theta.dot(theta_dot);
  const Vector3d t_x_td = theta.cross(theta_dot);
  // [theta']x theta' = 0 leaves one half of the products of J_l'.
  return c.da * x_dot * t_x_td + c.db * x_dot * theta.cross(t_x_td) + c.b * theta_dot.cross(t_x_td);
}

LeftJacobian::LeftJacobian(const Vector3d& theta) : theta_(theta) {
  // c_7 and c_6 by their series, the others downwards by c_k = 1 / k! - u c_k+2.
  constexpr double factorial[] = {1, 1, 2, 6, 24, 120, 720, 5040};
  const double u = theta.squaredNorm();
  double c[8];
  for (int k = 6; k < 8; ++k) {
    double term = 1.0 / factorial[k];
    c[k] = term;
    for (int j = 1; std::abs(term) > 1e-18 * std::abs(c[k]) && j < 200; ++j) {
      term *= -u / ((k + 2 * j) * (k + 2 * j - 1));
      c[k] += term;
    }
  }
  for (int k = 5; k >= 2; --k) c[k] = 1.0 / factorial[k] - u * c[k + 2];
  const auto slope = [&](int k) { return 0.5 * (k * c[k + 2] - c[k + 1]); };
  a_ = c[2];
  b_ = c[3];
  a_1_ = slope(2);
  b_1_ = slope(3);
  a_2_ = 0.5 * (2.0 * slope(4) - slope(3));
  b_2_ = 0.5 * (3.0 * slope(5) - slope(4));
}

Vector3d LeftJacobian::operator()(const Vector3d& x) const {
  const Vector3d tx = theta_.cross(x);
  return x + a_ * tx + b_ * theta_.cross(tx);
}

Vector3d LeftJacobian::first(const Vector3d& y, const Vector3d& x) const {
  const double u_y = 2.0 * theta_.dot(y);
  const Vector3d tx = theta_.cross(x), yx = y.cross(x);
  return a_1_ * u_y * tx + a_ * yx + b_1_ * u_y * theta_.cross(tx) + b_ * (y.cross(tx) + theta_.cross(yx));
}

Vector3d LeftJacobian::second(const Vector3d& y, const Vector3d& z, const Vector3d& x) const {
  const double u_y = 2.0 * theta_.dot(y), u_z = 2.0 * theta_.dot(z), u_yz = 2.0 * y.dot(z);
  const Vector3d tx = theta_.cross(x), yx = y.cross(x), zx = z.cross(x);
  return (a_2_ * u_y * u_z + a_1_ * u_yz) * tx + a_1_ * (u_y * zx + u_z * yx) +
         (b_2_ * u_y * u_z + b_1_ * u_yz) * theta_.cross(tx) +
         b_1_ * (u_y * (z.cross(tx) + theta_.cross(zx)) + u_z * (y.cross(tx) + theta_.cross(yx))) +
         b_ * (y.cross(zx) + z.cross(yx));
}

Matrix3d rotation_of_quaternion(const double* q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

Eigen::Vector4d quaternion_of_rotation(const Matrix3d& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  return sign * Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
}

void quaternion_rate(const double* q, const double* w, double* q_dot) {
  Eigen::Map<Eigen::Vector4d> out(q_dot);
  out = product({0.0, 0.5 * w[0], 0.5 * w[1], 0.5 * w[2]}, Eigen::Map<const Eigen::Vector4d>(q));
}

void quaternion_retract(const double* q, const double* d, double* q_out) {
  const Vector3d half = 0.5 * Vector3d(d[0], d[1], d[2]);
  const double x = half.squaredNorm();
  const Vector3d axis = coefficients(x).s * half;
  Eigen::Map<Eigen::Vector4d> out(q_out);
  out = product({std::cos(std::sqrt(x)), axis.x(), axis.y(), axis.z()}, Eigen::Map<const Eigen::Vector4d>(q))
            .eval()
            .normalized();
}

Matrix3d frame_along(const Vector3d& axis) {
  const double length = axis.norm();
  if (!(length > 0.0)) throw std::invalid_argument("an axis of zero length has no direction");
  Matrix3d R;
  R.col(2) = axis / length;
  // Of the three base vectors the one farthest from the axis; for an axis along z this gives the unit matrix.
  // Where two are equally far but for the digits of the axis it is the first, so that axes typed twice give
  // frames that agree.
  int k = 0;
  const double least = R.col(2).cwiseAbs().minCoeff();
  while (std::abs(R(k, 2)) > least + 1e-9) ++k;
  R.col(0) = (Vector3d::Unit(k) - R(k, 2) * R.col(2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

}  // namespace flexura::mbs
