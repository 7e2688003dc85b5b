// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// Translation along the common z axis.  Coordinate: `position` [m] of Mo from Fo along z.
/// Synonyms: slider, translational.
class Prismatic final : public Joint {
 public:
  std::string_view type() const override { return "prismatic"; }
  std::vector<CoordinateInfo> coordinates() const override { return {{"position", input::dim::length}}; }
  std::vector<CoordinateInfo> speeds() const override { return {{"speed", input::dim::velocity}}; }
  std::vector<CoordinateInfo> accelerations() const override {
    return {{"acceleration", input::dim::acceleration}};
  }
  int n_p() const override { return 1; }
  int n_v() const override { return 1; }

  Pose pose(const double* q) const override { return {Matrix3d::Identity(), {0, 0, q[0]}}; }
  bool has_constant_motion() const override { return true; }
  void motion(const double*, MotionMatrix& S) const override { S.col(0) = Vector6d::Unit(5); }
  void coordinates_of(const Pose& X, double* q) const override { q[0] = X.p.z(); }
  void speeds_of(const double*, const Vector6d& V, double* v) const override { v[0] = V(5); }

  void constrain(Rows& rows) const override {
    for (int i = 0; i < 2; ++i) rows.position_in_F(Vector3d::Unit(i));
    for (int i = 0; i < 3; ++i) rows.angle(Vector3d::Unit((i + 2) % 3), Vector3d::Unit((i + 1) % 3));
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"x", "y", "rotation_x", "rotation_y", "rotation_z"};
    return names[i];
  }
};

}  // namespace flexura::mbs
