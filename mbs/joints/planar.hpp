// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// Motion in the xy plane of F: coordinates `x`, `y` [m] of Mo and `angle` [rad] about z.
class Planar final : public Joint {
 public:
  std::string_view type() const override { return "planar"; }
  std::vector<CoordinateInfo> coordinates() const override {
    return {{"x", input::dim::length}, {"y", input::dim::length}, {"angle", input::dim::angle}};
  }
  std::vector<CoordinateInfo> speeds() const override {
    return {{"v_x", input::dim::velocity},
            {"v_y", input::dim::velocity},
            {"speed", input::dim::angular_velocity}};
  }
  std::vector<CoordinateInfo> accelerations() const override {
    return {{"a_x", input::dim::acceleration},
            {"a_y", input::dim::acceleration},
            {"acceleration", input::dim::angular_acceleration}};
  }
  int n_p() const override { return 3; }
  int n_v() const override { return 3; }

  Pose pose(const double* q) const override { return {rotation_about_z(q[2]), {q[0], q[1], 0}}; }
  bool has_constant_motion() const override { return true; }
  void motion(const double*, MotionMatrix& S) const override {
    S.col(0) = Vector6d::Unit(3);
    S.col(1) = Vector6d::Unit(4);
    S.col(2) = Vector6d::Unit(2);
  }
  void coordinates_of(const Pose& X, double* q) const override {
    q[0] = X.p.x();
    q[1] = X.p.y();
    q[2] = angle_about_z(X.R);
  }
  void speeds_of(const double*, const Vector6d& V, double* v) const override {
    v[0] = V(3);
    v[1] = V(4);
    v[2] = V(2);
  }

  void constrain(Rows& rows) const override {
    rows.position_in_F(Vector3d::UnitZ());
    for (int i = 0; i < 2; ++i) rows.angle(Vector3d::Unit(i), Vector3d::UnitZ());
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"z", "axis_x", "axis_y"};
    return names[i];
  }
};

}  // namespace flexura::mbs
