// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// Rotation about the common z axis.  Coordinate: `angle` [rad] of M in F, right-handed about z, counting
/// full turns. Synonyms: hinge, pin, torsion.
class Revolute final : public Joint {
 public:
  std::string_view type() const override { return "revolute"; }
  std::vector<CoordinateInfo> coordinates() const override { return {{"angle", input::dim::angle}}; }
  std::vector<CoordinateInfo> speeds() const override { return {{"speed", input::dim::angular_velocity}}; }
  std::vector<CoordinateInfo> accelerations() const override {
    return {{"acceleration", input::dim::angular_acceleration}};
  }
  int n_p() const override { return 1; }
  int n_v() const override { return 1; }

  Pose pose(const double* q) const override { return {rotation_about_z(q[0]), Vector3d::Zero()}; }
  bool has_constant_motion() const override { return true; }
  void motion(const double*, MotionMatrix& S) const override { S.col(0) = Vector6d::Unit(2); }
  void coordinates_of(const Pose& X, double* q) const override { q[0] = angle_about_z(X.R); }
  void speeds_of(const double*, const Vector6d& V, double* v) const override { v[0] = V(2); }

  void constrain(Rows& rows) const override {
    for (int i = 0; i < 3; ++i) rows.position_in_F(Vector3d::Unit(i));
    for (int i = 0; i < 2; ++i) rows.angle(Vector3d::Unit(i), Vector3d::UnitZ());
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"x", "y", "z", "axis_x", "axis_y"};
    return names[i];
  }
};

}  // namespace flexura::mbs
