// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/measures/shown_measure.hpp"

namespace flexura::mbs {

/// A component of the acceleration of marker M as seen from F: the second derivative of p_FoMo taken in F, or the first of
/// w_FM, along a unit vector in the axes of a third marker.  An accelerometer on a body is seen from ground, in its own axes.
class AccelerationMeasure final : public ShownMeasure {
 public:
  enum class Kind { linear, angular };
  AccelerationMeasure(std::string name, Kind kind, int F, int M, int axes, const Vector3d& direction)
      : ShownMeasure(std::move(name)), kind_(kind), F_(F), M_(M), axes_(axes), direction_(direction) {}
  input::Dimension dimension() const override {
    return kind_ == Kind::linear ? input::dim::acceleration : input::dim::angular_acceleration;
  }
  double value(const Kinematics& kin, const double*) const override {
    const Vector6d A = kin.relative_acceleration(F_, M_).A;
    const Vector3d in_W = kin.markers[F_].X_WP.R * (kind_ == Kind::linear ? A.tail<3>() : A.head<3>());
    return in_W.dot(kin.markers[axes_].X_WP.R * direction_);
  }

 private:
  Kind kind_;
  int F_, M_, axes_;
  Vector3d direction_;
};

}  // namespace flexura::mbs
