// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/base/math/spatial.hpp"

/// Rotations by vector and by quaternion.
///
///     exp(theta) = 1 + sin(phi)/phi [theta]x + (1 - cos phi)/phi^2 [theta]x^2,          phi = |theta|
///     J_l(theta) = 1 + a [theta]x + b [theta]x^2,   a = (1 - cos phi)/phi^2, b = (phi - sin phi)/phi^3
///
/// The angular velocity of R = exp(theta), expressed in the frame that R maps into, is J_l(theta) theta'
/// (Chirikjian, Stochastic Models, Information Theory, and Lie Groups 2, ch. 10).
///
/// Quaternions are (w, x, y, z) and are normalised when read: only their direction counts.
namespace flexura::mbs {

Matrix3d rotation_exp(const Vector3d& theta);

/// The rotation vector of R, |theta| <= pi.
Vector3d rotation_log(const Matrix3d& R);

/// J_l(theta).
Matrix3d left_jacobian(const Vector3d& theta);

/// d/dt J_l(theta(t)) theta' : what stands beside J_l theta'' in the angular acceleration.
Vector3d left_jacobian_bias(const Vector3d& theta, const Vector3d& theta_dot);

/// Derivatives of J_l(theta) x for a fixed x, with a, b and their derivatives by theta^2 from
/// c_k(u) = sum_j (-u)^j / (k + 2 j)!,   a = c_2,   b = c_3,   c_k' = (k c_k+2 - c_k+1) / 2
/// (Stumpff's functions).
class LeftJacobian {
 public:
  explicit LeftJacobian(const Vector3d& theta);
  /// J_l x.
  Vector3d operator()(const Vector3d& x) const;
  /// As theta moves along y.
  Vector3d first(const Vector3d& y, const Vector3d& x) const;
  /// As theta moves along y and z.
  Vector3d second(const Vector3d& y, const Vector3d& z, const Vector3d& x) const;

 private:
  Vector3d theta_;
  double a_, a_1_, a_2_, b_, b_1_, b_2_;
};

/// R of the quaternion q (4 numbers, any length but zero).
Matrix3d rotation_of_quaternion(const double* q);

/// The unit quaternion of R with w >= 0.
Eigen::Vector4d quaternion_of_rotation(const Matrix3d& R);

/// q' = 1/2 (0, w) * q for an angular velocity w expressed in the frame that R(q) maps into.
void quaternion_rate(const double* q, const double* w, double* q_dot);

/// The unit quaternion of exp(d) R(q), on the same side of the sphere as q.
void quaternion_retract(const double* q, const double* d, double* q_out);

/// A right-handed frame whose z axis points along `axis`, x chosen well away from it.
/// Throws std::invalid_argument when the axis has no length.
Matrix3d frame_along(const Vector3d& axis);

}  // namespace flexura::mbs
