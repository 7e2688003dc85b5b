// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

/// No relative motion: the frames stay together.  Synonyms: weld, rigid.
class Fixed final : public Joint {
 public:
  std::string_view type() const override { return "fixed"; }
  std::vector<CoordinateInfo> coordinates() const override { return {}; }
  std::vector<CoordinateInfo> speeds() const override { return {}; }
  std::vector<CoordinateInfo> accelerations() const override { return {}; }
  int n_p() const override { return 0; }
  int n_v() const override { return 0; }

  Pose pose(const double*) const override { return {}; }
  bool has_constant_motion() const override { return true; }
  void motion(const double*, MotionMatrix&) const override {}
  void coordinates_of(const Pose&, double*) const override {}
  void speeds_of(const double*, const Vector6d&, double*) const override {}

  void constrain(Rows& rows) const override {
    for (int i = 0; i < 3; ++i) rows.position_in_F(Vector3d::Unit(i));
    for (int i = 0; i < 3; ++i) rows.angle(Vector3d::Unit((i + 2) % 3), Vector3d::Unit((i + 1) % 3));
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"x", "y", "z", "rotation_x", "rotation_y", "rotation_z"};
    return names[i];
  }
};

}  // namespace flexura::mbs
