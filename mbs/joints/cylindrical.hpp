// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// Rotation about and translation along the common z axis.  Coordinates: `angle` [rad], `position` [m].
class Cylindrical final : public Joint {
 public:
  std::string_view type() const override { return "cylindrical"; }
  std::vector<CoordinateInfo> coordinates() const override {
    return {{"angle", input::dim::angle}, {"position", input::dim::length}};
  }
  std::vector<CoordinateInfo> speeds() const override {
    return {{"angular_speed", input::dim::angular_velocity}, {"speed", input::dim::velocity}};
  }
  std::vector<CoordinateInfo> accelerations() const override {
    return {{"angular_acceleration", input::dim::angular_acceleration},
            {"acceleration", input::dim::acceleration}};
  }
  int n_p() const override { return 2; }
  int n_v() const override { return 2; }

  Pose pose(const double* q) const override { return {rotation_about_z(q[0]), {0, 0, q[1]}}; }
  bool has_constant_motion() const override { return true; }
  void motion(const double*, MotionMatrix& S) const override {
    S.col(0) = Vector6d::Unit(2);
    S.col(1) = Vector6d::Unit(5);
  }
  void coordinates_of(const Pose& X, double* q) const override {
    q[0] = angle_about_z(X.R);
    q[1] = X.p.z();
  }
  void speeds_of(const double*, const Vector6d& V, double* v) const override {
    v[0] = V(2);
    v[1] = V(5);
  }

  void constrain(Rows& rows) const override {
    for (int i = 0; i < 2; ++i) rows.position_in_F(Vector3d::Unit(i));
    for (int i = 0; i < 2; ++i) rows.angle(Vector3d::Unit(i), Vector3d::UnitZ());
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"x", "y", "axis_x", "axis_y"};
    return names[i];
  }
};

}  // namespace flexura::mbs
