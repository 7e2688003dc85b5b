// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/measures/relative_measure.hpp"

#include <cmath>

namespace flexura::mbs {
namespace {

using Row = RelativeQuantity::Row;

/// A row that has one block of three.
Row row(int first, const Vector3d& x) {
  Row r = Row::Zero();
  r.segment<3>(first) = x.transpose();
  return r;
}

double measured_distance(const Kinematics& kin, int F, int M, const Vector3d&) {
  return (kin.markers[M].X_WP.p - kin.markers[F].X_WP.p).norm();
}
double measured_distance_rate(const Kinematics& kin, int F, int M, const Vector3d&) {
  const Vector3d r = kin.markers[M].X_WP.p - kin.markers[F].X_WP.p;
  const double length = r.norm();
  return length > 0.0 ? r.dot(kin.markers[M].V.linear - kin.markers[F].V.linear) / length : 0.0;
}
double measured_position(const Kinematics& kin, int F, int M, const Vector3d& e) {
  return kin.relative_pose(F, M).p.dot(e);
}
double measured_axis_component(const Kinematics& kin, int F, int M, const Vector3d& e) {
  return kin.markers[M].X_WP.R.col(2).dot(kin.markers[F].X_WP.R * e);
}
double measured_velocity(const Kinematics& kin, int F, int M, const Vector3d& e) {
  return kin.relative_motion(F, M).V.tail<3>().dot(e);
}
double measured_angle(const Kinematics& kin, int F, int M, const Vector3d&) {
  const Matrix3d R = kin.relative_pose(F, M).R;
  return std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
}
double measured_angular_velocity(const Kinematics& kin, int F, int M, const Vector3d& e) {
  return kin.relative_motion(F, M).V.head<3>().dot(e);
}

Row distance_gradient(const Relative& rel, const Vector3d&) {
  const double length = rel.X_FM.p.norm();
  return length > 0.0 ? row(3, rel.X_FM.p / length) : Row(Row::Zero());
}
Row distance_rate_gradient(const Relative& rel, const Vector3d&) {
  const double length = rel.X_FM.p.norm();
  if (length == 0.0) return Row::Zero();
  const Vector3d e = rel.X_FM.p / length, u = rel.V.tail<3>();
  return row(3, (u - e * e.dot(u)) / length) + row(9, e);
}
Row position_gradient(const Relative&, const Vector3d& e) {
  return row(3, e);
}
Row axis_gradient(const Relative& rel, const Vector3d& e) {
  return row(0, Vector3d(rel.X_FM.R.col(2)).cross(e));
}
Row velocity_gradient(const Relative&, const Vector3d& e) {
  return row(9, e);
}
Row angle_gradient(const Relative& rel, const Vector3d&) {
  return row(0, TurnAboutZ(rel.X_FM.R, Vector3d::Zero()).gradient);
}
Row angular_velocity_gradient(const Relative&, const Vector3d& e) {
  return row(6, e);
}

double pose_distance(const Pose& X, const Vector3d&) {
  return X.p.norm();
}
double pose_position(const Pose& X, const Vector3d& e) {
  return X.p.dot(e);
}
double pose_axis(const Pose& X, const Vector3d& e) {
  return X.R.col(2).dot(e);
}
double pose_angle(const Pose& X, const Vector3d&) {
  return angle_about_z(X.R);
}

double distance_bias(const Relative& rel, const Vector3d&) {
  const double length = rel.X_FM.p.norm();
  if (length == 0.0) return 0.0;
  const Vector3d u = rel.V.tail<3>();
  const double along = rel.X_FM.p.dot(u) / length;
  return (u.squaredNorm() - along * along) / length;
}
double position_bias(const Relative&, const Vector3d&) {
  return 0.0;
}
double axis_bias(const Relative& rel, const Vector3d& e) {
  const Vector3d w = rel.V.head<3>();
  return w.cross(w.cross(Vector3d(rel.X_FM.R.col(2)))).dot(e);
}
double angle_bias(const Relative& rel, const Vector3d&) {
  return TurnAboutZ(rel.X_FM.R, rel.V.head<3>()).bias;
}

}  // namespace

RelativeQuantity RelativeQuantity::distance() {
  return {measured_distance, distance_gradient, input::dim::length, false, true,
          pose_distance,     distance_bias};
}
RelativeQuantity RelativeQuantity::distance_rate() {
  return {measured_distance_rate, distance_rate_gradient, input::dim::velocity, false, false};
}
RelativeQuantity RelativeQuantity::position() {
  return {measured_position, position_gradient, input::dim::length, true, true, pose_position, position_bias};
}
RelativeQuantity RelativeQuantity::axis() {
  return {measured_axis_component, axis_gradient, input::dim::none, true, true, pose_axis, axis_bias};
}
RelativeQuantity RelativeQuantity::velocity() {
  return {measured_velocity, velocity_gradient, input::dim::velocity, true, false};
}
RelativeQuantity RelativeQuantity::angle() {
  return {measured_angle, angle_gradient, input::dim::angle, false, true, pose_angle, angle_bias};
}
RelativeQuantity RelativeQuantity::angular_velocity() {
  return {measured_angular_velocity, angular_velocity_gradient, input::dim::angular_velocity, true, false};
}

}  // namespace flexura::mbs
