// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// Free rotation about the common origin.  Coordinates: the quaternion (`qw`, `qx`, `qy`, `qz`) of R_FM, so
/// every attitude is as good as another; speeds: w_FM_F.  Synonyms: ball, S joint.
class Spherical final : public Joint {
 public:
  std::string_view type() const override { return "spherical"; }
  std::vector<CoordinateInfo> coordinates() const override {
    return {{"qw", input::dim::none},
            {"qx", input::dim::none},
            {"qy", input::dim::none},
            {"qz", input::dim::none}};
  }
  std::vector<CoordinateInfo> speeds() const override {
    const auto d = input::dim::angular_velocity;
    return {{"omega_x", d}, {"omega_y", d}, {"omega_z", d}};
  }
  std::vector<CoordinateInfo> accelerations() const override {
    const auto d = input::dim::angular_acceleration;
    return {{"alpha_x", d}, {"alpha_y", d}, {"alpha_z", d}};
  }
  int n_p() const override { return 4; }
  int n_v() const override { return 3; }

  Pose pose(const double* q) const override { return {rotation_of_quaternion(q), Vector3d::Zero()}; }
  bool has_constant_motion() const override { return true; }
  void motion(const double*, MotionMatrix& S) const override {
    S.topRows<3>().setIdentity();
    S.bottomRows<3>().setZero();
  }
  void kinematic(const double* q, const double* w, double* q_dot) const override {
    quaternion_rate(q, w, q_dot);
  }
  void retract(const double* q, const double* d, double* q_out) const override {
    quaternion_retract(q, d, q_out);
  }
  void coordinates_of(const Pose& X, double* q) const override {
    Eigen::Map<Eigen::Vector4d> out(q);
    out = quaternion_of_rotation(X.R);
  }
  void speeds_of(const double*, const Vector6d& V, double* v) const override {
    for (int i = 0; i < 3; ++i) v[i] = V(i);
  }
  void reference(double* q) const override {
    q[0] = 1.0;
    q[1] = q[2] = q[3] = 0.0;
  }

  void constrain(Rows& rows) const override {
    for (int i = 0; i < 3; ++i) rows.position_in_F(Vector3d::Unit(i));
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"x", "y", "z"};
    return names[i];
  }
};

}  // namespace flexura::mbs
