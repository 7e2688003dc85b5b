// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

/// Poses, twists, wrenches and rigid-body inertia.
///
/// A twist of a frame B in W is the pair (w_WB, v_WBo), a wrench on it the pair (torque about Bo, force);
/// both carry their angular part first, so that power = wrench . twist.  The frame in which the two vectors
/// are expressed is said where they are used (bodies: W; one frame relative to another: the frame that is
/// taken to be at rest).
namespace flexura::mbs {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// [a]x, so that skew(a) b = a x b.
inline Matrix3d skew(const Vector3d& a) {
  Matrix3d s;
  s << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return s;
}

/// X_AB: position p_AoBo_A and rotation R_AB of a frame B in A.  X_AC = X_AB * X_BC.
struct Pose {
  Matrix3d R = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero();

  Pose operator*(const Pose& X) const { return {R * X.R, p + R * X.p}; }
  Vector3d operator*(const Vector3d& x) const { return p + R * x; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

/// An angular and a linear vector: a twist, a spatial acceleration (alpha, a of the origin) or a wrench.
struct Spatial {
  Vector3d angular = Vector3d::Zero();
  Vector3d linear = Vector3d::Zero();

  Spatial& operator+=(const Spatial& b) {
    angular += b.angular;
    linear += b.linear;
    return *this;
  }
  Spatial& operator-=(const Spatial& b) {
    angular -= b.angular;
    linear -= b.linear;
    return *this;
  }
  friend Spatial operator+(Spatial a, const Spatial& b) { return a += b; }
  friend Spatial operator-(Spatial a, const Spatial& b) { return a -= b; }
  friend Spatial operator-(const Spatial& a) { return {-a.angular, -a.linear}; }
  friend Spatial operator*(const Matrix3d& R, const Spatial& b) { return {R * b.angular, R * b.linear}; }
  double dot(const Spatial& b) const { return angular.dot(b.angular) + linear.dot(b.linear); }

  Vector6d vector() const { return (Vector6d() << angular, linear).finished(); }
  static Spatial from(const Vector6d& x) { return {x.head<3>(), x.tail<3>()}; }
};

/// The wrench about another point: `r` leads from the new point to the old one.
inline Spatial shift_wrench(const Spatial& w, const Vector3d& r) {
  return {w.angular + r.cross(w.linear), w.linear};
}

/// The twist of another point of the same frame: `r` leads from the old point to the new one.
inline Spatial shift_twist(const Spatial& t, const Vector3d& r) {
  return {t.angular, t.linear + t.angular.cross(r)};
}

/// a x b of two motions about one point: how b changes with the frame that moves by a.
inline Spatial cross_motion(const Spatial& a, const Spatial& b) {
  return {a.angular.cross(b.angular), a.angular.cross(b.linear) + a.linear.cross(b.angular)};
}

/// a x* f of a motion and a wrench about one point: how f changes with the frame that moves by a.
inline Spatial cross_force(const Spatial& a, const Spatial& f) {
  return {a.angular.cross(f.angular) + a.linear.cross(f.linear), a.angular.cross(f.linear)};
}

/// Mass properties of a rigid body about its origin Bo, expressed in B.
struct RigidInertia {
  double mass = 0.0;
  Vector3d mass_center = Vector3d::Zero();  ///< mass * p_BoBcm_B, the first moment [kg m]
  Matrix3d inertia = Matrix3d::Zero();      ///< about Bo [kg m^2], integral of (|x|^2 1 - x x^T) dm

  /// From the centre of mass and the inertia about it.
  static RigidInertia from_center(double mass, const Vector3d& p_BoBcm_B, const Matrix3d& inertia_cm) {
    const Vector3d& c = p_BoBcm_B;
    return {mass, mass * c, inertia_cm + mass * (c.squaredNorm() * Matrix3d::Identity() - c * c.transpose())};
  }
};

}  // namespace flexura::mbs
