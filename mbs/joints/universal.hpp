// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// Two rotations about crossing perpendicular axes: first about the axis a of F, then about the axis b that M
/// carries. R_FM = R_a(angle_1) R_b(angle_2).  Orders (Simpack's names): al-be = x then y, be-ga = y then z,
/// al-ga = x then z. Synonyms: Hooke, Cardan joint.
class Universal final : public Joint {
 public:
  /// Axes fixed in F and in M: 0, 1, 2 for x, y, z.
  explicit Universal(int a = 0, int b = 1) : a_(Vector3d::Unit(a)), b_(Vector3d::Unit(b)), c_(a_.cross(b_)) {}
  std::string_view type() const override { return "universal"; }
  std::vector<CoordinateInfo> coordinates() const override {
    return {{"angle_1", input::dim::angle}, {"angle_2", input::dim::angle}};
  }
  std::vector<CoordinateInfo> speeds() const override {
    return {{"speed_1", input::dim::angular_velocity}, {"speed_2", input::dim::angular_velocity}};
  }
  std::vector<CoordinateInfo> accelerations() const override {
    return {{"acceleration_1", input::dim::angular_acceleration},
            {"acceleration_2", input::dim::angular_acceleration}};
  }
  int n_p() const override { return 2; }
  int n_v() const override { return 2; }

  Pose pose(const double* q) const override {
    return {rotation_exp(q[0] * a_) * rotation_exp(q[1] * b_), Vector3d::Zero()};
  }
  void motion(const double* q, MotionMatrix& S) const override {
    S.col(0) << a_, Vector3d::Zero();
    S.col(1) << second_axis(q), Vector3d::Zero();
  }
  Vector6d bias(const double* q, const double* v) const override {
    Vector6d bias = Vector6d::Zero();
    bias.head<3>() = v[0] * v[1] * a_.cross(second_axis(q));
    return bias;
  }
  void motion_derivatives(const double* q, const double* v, MotionDerivatives& d) const override {
    const Vector3d second = second_axis(q), slope = a_.cross(second);  // second'' = -second
    for (MotionMatrix& S : d.S_q) S.setZero(6, 2);
    d.bias_q.setZero(6, 2);
    d.bias_v.setZero(6, 2);
    d.S_q[0].col(1).head<3>() = slope;
    d.bias_q.col(0).head<3>() = -v[0] * v[1] * second;
    d.bias_v.col(0).head<3>() = v[1] * slope;
    d.bias_v.col(1).head<3>() = v[0] * slope;
  }
  void coordinates_of(const Pose& X, double* q) const override {
    const Vector3d carried = X.R * b_;
    q[0] = std::atan2(c_.dot(carried), b_.dot(carried));
    const Vector3d turned = rotation_exp(q[0] * a_).transpose() * X.R * a_;
    q[1] = std::atan2(-c_.dot(turned), a_.dot(turned));  // b x a = -c
  }
  void speeds_of(const double* q, const Vector6d& V, double* v) const override {
    v[0] = a_.dot(V.head<3>());
    v[1] = second_axis(q).dot(V.head<3>());
  }

  void constrain(Rows& rows) const override {
    for (int i = 0; i < 3; ++i) rows.position_in_F(Vector3d::Unit(i));
    rows.angle(a_, b_);
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"x", "y", "z", "cross"};
    return names[i];
  }

 private:
  Vector3d second_axis(const double* q) const { return std::cos(q[0]) * b_ + std::sin(q[0]) * c_; }
  Vector3d a_, b_, c_;
};

}  // namespace flexura::mbs
