// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// All six freedoms.  Coordinates: the quaternion of R_FM, then p_FoMo_F [m]; speeds: w_FM_F, then its
/// derivative. Synonyms: free joint.  A body without any joint gets one of these to ground.
class SixDof final : public Joint {
 public:
  std::string_view type() const override { return "six_dof"; }
  std::vector<CoordinateInfo> coordinates() const override {
    const auto d = input::dim::none;
    const auto l = input::dim::length;
    return {{"qw", d}, {"qx", d}, {"qy", d}, {"qz", d}, {"x", l}, {"y", l}, {"z", l}};
  }
  std::vector<CoordinateInfo> speeds() const override {
    const auto d = input::dim::angular_velocity;
    const auto l = input::dim::velocity;
    return {{"omega_x", d}, {"omega_y", d}, {"omega_z", d}, {"v_x", l}, {"v_y", l}, {"v_z", l}};
  }
  std::vector<CoordinateInfo> accelerations() const override {
    const auto d = input::dim::angular_acceleration;
    const auto l = input::dim::acceleration;
    return {{"alpha_x", d}, {"alpha_y", d}, {"alpha_z", d}, {"a_x", l}, {"a_y", l}, {"a_z", l}};
  }
  int n_p() const override { return 7; }
  int n_v() const override { return 6; }

  Pose pose(const double* q) const override { return {rotation_of_quaternion(q), {q[4], q[5], q[6]}}; }
  bool has_constant_motion() const override { return true; }
  void motion(const double*, MotionMatrix& S) const override { S.setIdentity(); }
  void kinematic(const double* q, const double* w, double* q_dot) const override {
    quaternion_rate(q, w, q_dot);
    for (int i = 0; i < 3; ++i) q_dot[4 + i] = w[3 + i];
  }
  void retract(const double* q, const double* d, double* q_out) const override {
    quaternion_retract(q, d, q_out);
    for (int i = 0; i < 3; ++i) q_out[4 + i] = q[4 + i] + d[3 + i];
  }
  void coordinates_of(const Pose& X, double* q) const override {
    Eigen::Map<Eigen::Vector4d> out(q);
    out = quaternion_of_rotation(X.R);
    for (int i = 0; i < 3; ++i) q[4 + i] = X.p(i);
  }
  void speeds_of(const double*, const Vector6d& V, double* v) const override {
    for (int i = 0; i < 6; ++i) v[i] = V(i);
  }
  void reference(double* q) const override {
    q[0] = 1.0;
    for (int i = 1; i < 7; ++i) q[i] = 0.0;
  }

  void constrain(Rows&) const override {}
  std::string row_name(int) const override { return {}; }
};

}  // namespace flexura::mbs
