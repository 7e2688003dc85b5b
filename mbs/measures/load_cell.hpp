// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/measures/shown_measure.hpp"

namespace flexura::mbs {

/// A component of the force through a joint, or of the torque about the origin of the marker `at`, on the body of the
/// joint's marker M, along a unit vector in the axes of a marker.
class LoadCell final : public ShownMeasure {
 public:
  enum class Kind { force, torque };
  /// F and M: the joint's markers.
  LoadCell(std::string name, Kind kind, int joint, int F, int M, int at, int axes, const Vector3d& direction)
      : ShownMeasure(std::move(name)),
        kind_(kind),
        joint_(joint),
        F_(F),
        M_(M),
        at_(at),
        axes_(axes),
        direction_(direction) {}
  input::Dimension dimension() const override {
    return kind_ == Kind::force ? input::dim::force : input::dim::torque;
  }
  double value(const Kinematics&, const double*) const override { return 0.0; }
  Exerted exerted() const override { return {Exerted::By::joint, joint_}; }
  double value_of_load(const Kinematics& kin, const double* load) const override {
    const Spatial on_M = kin.markers[F_].X_WP.R * Spatial::from(Eigen::Map<const Vector6d>(load));
    const Spatial there = shift_wrench(on_M, kin.markers[M_].X_WP.p - kin.markers[at_].X_WP.p);
    return (kind_ == Kind::force ? there.linear : there.angular).dot(kin.markers[axes_].X_WP.R * direction_);
  }

 private:
  Kind kind_;
  int joint_, F_, M_, at_, axes_;
  Vector3d direction_;
};

}  // namespace flexura::mbs
