// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// Bending without twist about the common origin, so that both shafts turn (about their z axes) at the same
/// rate: R_FM = exp(theta) with theta in the xy plane of F.  Coordinates: its components `bend_x`, `bend_y`
/// [rad], |theta| < 2 pi.  The row R_10 - R_01 = 0 says that theta has no z component.  Synonym: homokinetic
/// joint.
class ConstantVelocity final : public Joint {
 public:
  std::string_view type() const override { return "constant_velocity"; }
  std::vector<CoordinateInfo> coordinates() const override {
    return {{"bend_x", input::dim::angle}, {"bend_y", input::dim::angle}};
  }
  std::vector<CoordinateInfo> speeds() const override {
    return {{"bend_rate_x", input::dim::angular_velocity}, {"bend_rate_y", input::dim::angular_velocity}};
  }
  std::vector<CoordinateInfo> accelerations() const override {
    return {{"bend_acceleration_x", input::dim::angular_acceleration},
            {"bend_acceleration_y", input::dim::angular_acceleration}};
  }
  int n_p() const override { return 2; }
  int n_v() const override { return 2; }

  Pose pose(const double* q) const override { return {rotation_exp({q[0], q[1], 0}), Vector3d::Zero()}; }
  void motion(const double* q, MotionMatrix& S) const override {
    const Matrix3d J_l = left_jacobian({q[0], q[1], 0});
    for (int i = 0; i < 2; ++i) S.col(i) << J_l.col(i), Vector3d::Zero();
  }
  Vector6d bias(const double* q, const double* v) const override {
    Vector6d bias = Vector6d::Zero();
    bias.head<3>() = left_jacobian_bias({q[0], q[1], 0}, {v[0], v[1], 0});
    return bias;
  }
  void motion_derivatives(const double* q, const double* v, MotionDerivatives& d) const override {
    const LeftJacobian J({q[0], q[1], 0});
    const Vector3d rate(v[0], v[1], 0);
    for (MotionMatrix& S : d.S_q) S.setZero(6, 2);
    d.bias_q.setZero(6, 2);
    d.bias_v.setZero(6, 2);
    for (int j = 0; j < 2; ++j) {
      const Vector3d e = Vector3d::Unit(j);
      for (int i = 0; i < 2; ++i) d.S_q[j].col(i).head<3>() = J.first(e, Vector3d::Unit(i));
      d.bias_q.col(j).head<3>() = J.second(e, rate, rate);
      d.bias_v.col(j).head<3>() = J.first(e, rate) + J.first(rate, e);
    }
  }
  void coordinates_of(const Pose& X, double* q) const override {
    // The z axis of M, seen from F, leans by the angle of theta about theta.
    const Vector3d lean(-X.R(1, 2), X.R(0, 2), 0.0);
    const double sine = lean.norm();
    const double factor = sine > 0.0 ? std::atan2(sine, X.R(2, 2)) / sine : 1.0;
    q[0] = factor * lean.x();
    q[1] = factor * lean.y();
  }
  void speeds_of(const double* q, const Vector6d& V, double* v) const override {
    const Eigen::Matrix<double, 3, 2> J = left_jacobian({q[0], q[1], 0}).leftCols<2>();
    const double a = J.col(0).squaredNorm(), b = J.col(0).dot(J.col(1)), d = J.col(1).squaredNorm();
    const Eigen::Vector2d f = J.transpose() * V.head<3>();
    v[0] = (d * f(0) - b * f(1)) / (a * d - b * b);
    v[1] = (a * f(1) - b * f(0)) / (a * d - b * b);
  }

  void constrain(Rows& rows) const override {
    for (int i = 0; i < 3; ++i) rows.position_in_F(Vector3d::Unit(i));
    rows.twist();
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"x", "y", "z", "twist"};
    return names[i];
  }
};

}  // namespace flexura::mbs
