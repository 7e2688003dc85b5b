// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/measures/measure.hpp"

namespace flexura::mbs {

/// What can be measured of the motion of one marker M relative to another F.
struct RelativeQuantity {
  using Function = double (*)(const Kinematics&, int F, int M, const Vector3d& direction);
  /// Its derivatives by X_FM and V_FM (Derivatives::by_relative).
  using Row = Eigen::Matrix<double, 1, 12>;
  using Gradient = Row (*)(const Relative& rel, const Vector3d& direction);

  Function value;
  Gradient gradient;
  input::Dimension dimension;
  bool has_direction = false;
  bool is_of_positions = true;
  /// Of positions: the value by the pose, and what of its second derivative by time is not gradient . V_FM'.
  using OfPose = double (*)(const Pose& X_FM, const Vector3d& direction);
  using Bias = double (*)(const Relative& rel, const Vector3d& direction);
  OfPose of_pose = nullptr;
  Bias bias = nullptr;

  static RelativeQuantity distance();          ///< of the two origins
  static RelativeQuantity distance_rate();     ///< its time derivative
  static RelativeQuantity position();          ///< component of the position of M in F
  static RelativeQuantity axis();              ///< component of the z axis of M in F, a direction cosine
  static RelativeQuantity velocity();          ///< component of the velocity of M as seen from F
  static RelativeQuantity angle();             ///< of M about the z axis of F, within +-pi
  static RelativeQuantity angular_velocity();  ///< component of the angular velocity of M as seen from F
};

/// A scalar of the motion of one marker M relative to another F.
class RelativeMeasure : public Measure {
 public:
  /// `direction`: a unit vector in the axes of F, where the quantity is a component.
  RelativeMeasure(std::string name, int F, int M, const RelativeQuantity& quantity,
                  const Vector3d& direction = Vector3d::Zero())
      : Measure(std::move(name)), F_(F), M_(M), direction_(direction), quantity_(quantity) {}
  input::Dimension dimension() const override { return quantity_.dimension; }
  double value(const Kinematics& kin, const double*) const override {
    return quantity_.value(kin, F_, M_, direction_);
  }
  bool is_of_positions() const override { return quantity_.is_of_positions; }
  std::pair<int, int> markers_of_pose() const override {
    return quantity_.bias ? std::pair{F_, M_} : std::pair{-1, -1};
  }
  PoseFunction of_pose(const Relative& rel) const override {
    return {quantity_.of_pose(rel.X_FM, direction_),
            quantity_.gradient(rel, direction_).head<6>().transpose(), quantity_.bias(rel, direction_)};
  }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    d.rows();
    d.by_relative(F_, M_, quantity_.gradient(kin.relative_motion(F_, M_), direction_));
  }

 private:
  int F_, M_;
  Vector3d direction_;
  RelativeQuantity quantity_;
};

/// One that a force element makes of itself, "pull.length": the same as its output of that name.
class MeasureOfElement final : public RelativeMeasure {
 public:
  using RelativeMeasure::RelativeMeasure;
};

}  // namespace flexura::mbs
