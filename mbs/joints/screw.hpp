// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <numbers>

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// Rotation about the common z axis with translation in proportion.  Coordinate: `angle` [rad]; the position
/// along z is pitch angle / 2 pi.  Synonym: helical joint.
class Screw final : public Joint {
 public:
  /// `pitch` [m]: translation in one full turn, negative for a left-hand thread; not 0.
  explicit Screw(double pitch = 0.5) : rise_(pitch / (2.0 * std::numbers::pi)) {}
  std::string_view type() const override { return "screw"; }
  std::vector<CoordinateInfo> coordinates() const override { return {{"angle", input::dim::angle}}; }
  std::vector<CoordinateInfo> speeds() const override { return {{"speed", input::dim::angular_velocity}}; }
  std::vector<CoordinateInfo> accelerations() const override {
    return {{"acceleration", input::dim::angular_acceleration}};
  }
  int n_p() const override { return 1; }
  int n_v() const override { return 1; }

  Pose pose(const double* q) const override { return {rotation_about_z(q[0]), {0, 0, rise_ * q[0]}}; }
  bool has_constant_motion() const override { return true; }
  void motion(const double*, MotionMatrix& S) const override {
    S.col(0) = Vector6d::Unit(2) + rise_ * Vector6d::Unit(5);
  }
  /// The turn comes from the rotation, the number of full turns from the position.
  void coordinates_of(const Pose& X, double* q) const override {
    const double angle = angle_about_z(X.R), turn = 2.0 * std::numbers::pi;
    q[0] = angle + turn * std::rint((X.p.z() / rise_ - angle) / turn);
  }
  void speeds_of(const double*, const Vector6d& V, double* v) const override { v[0] = V(2); }

  void constrain(Rows& rows) const override {
    for (int i = 0; i < 2; ++i) rows.position_in_F(Vector3d::Unit(i));
    for (int i = 0; i < 2; ++i) rows.angle(Vector3d::Unit(i), Vector3d::UnitZ());
    double angle;
    coordinates_of(rows.X_FM(), &angle);
    const TurnAboutZ turn(rows.X_FM().R, rows.angular());
    rows.add(rows.X_FM().p.z() - rise_ * angle, -rise_ * turn.gradient, Vector3d::UnitZ(),
             -rise_ * turn.bias);
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"x", "y", "axis_x", "axis_y", "thread"};
    return names[i];
  }

 private:
  double rise_;  ///< [m/rad]
};

}  // namespace flexura::mbs
