// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/joints/joint.hpp"

/// Joints that restrain little: what constraints of the same names take away, as motion.
namespace flexura::mbs {

/// Sliding along some axes of F with no rotation, one about z, or any about Mo.
///
/// Coordinates: first the rotation's (`qw`, `qx`, `qy`, `qz` of R_FM, or `angle` [rad]), then `x`, `y`, `z`
/// [m] of Mo as far as they are free; speeds: w_FM_F or the rate of the angle, then d/dt p_FoMo_F.
class Partial final : public Joint {
 public:
  enum class Turn { none, about_z, any };
  Partial(const char* type, Turn turn, std::vector<int> slides)
      : type_(type), turn_(turn), slides_(std::move(slides)) {}
  std::string_view type() const override { return type_; }
  std::vector<CoordinateInfo> coordinates() const override {
    std::vector<CoordinateInfo> list;
    if (turn_ == Turn::any)
      for (const char* name : {"qw", "qx", "qy", "qz"}) list.push_back({name, input::dim::none});
    if (turn_ == Turn::about_z) list.push_back({"angle", input::dim::angle});
    add_slides(list, "", input::dim::length);
    return list;
  }
  std::vector<CoordinateInfo> speeds() const override {
    return rates("omega_", "speed", "v_", input::dim::angular_velocity, input::dim::velocity);
  }
  std::vector<CoordinateInfo> accelerations() const override {
    return rates("alpha_", "acceleration", "a_", input::dim::angular_acceleration, input::dim::acceleration);
  }
  int n_p() const override { return n_q() + n_slides(); }
  int n_v() const override { return n_w() + n_slides(); }

  Pose pose(const double* q) const override {
    Pose X;
    if (turn_ == Turn::any) X.R = rotation_of_quaternion(q);
    if (turn_ == Turn::about_z) X.R = rotation_about_z(q[0]);
    for (int i = 0; i < n_slides(); ++i) X.p(slides_[i]) = q[n_q() + i];
    return X;
  }
  bool has_constant_motion() const override { return true; }
  void motion(const double*, MotionMatrix& S) const override {
    if (turn_ == Turn::any)
      for (int i = 0; i < 3; ++i) S.col(i) = Vector6d::Unit(i);
    if (turn_ == Turn::about_z) S.col(0) = Vector6d::Unit(2);
    for (int i = 0; i < n_slides(); ++i) S.col(n_w() + i) = Vector6d::Unit(3 + slides_[i]);
  }
  void kinematic(const double* q, const double* w, double* q_dot) const override {
    if (turn_ == Turn::any) quaternion_rate(q, w, q_dot);
    if (turn_ == Turn::about_z) q_dot[0] = w[0];
    for (int i = 0; i < n_slides(); ++i) q_dot[n_q() + i] = w[n_w() + i];
  }
  void retract(const double* q, const double* d, double* q_out) const override {
    if (turn_ == Turn::any) quaternion_retract(q, d, q_out);
    if (turn_ == Turn::about_z) q_out[0] = q[0] + d[0];
    for (int i = 0; i < n_slides(); ++i) q_out[n_q() + i] = q[n_q() + i] + d[n_w() + i];
  }
  void coordinates_of(const Pose& X, double* q) const override {
    if (turn_ == Turn::any) {
      Eigen::Map<Eigen::Vector4d> out(q);
      out = quaternion_of_rotation(X.R);
    }
    if (turn_ == Turn::about_z) q[0] = angle_about_z(X.R);
    for (int i = 0; i < n_slides(); ++i) q[n_q() + i] = X.p(slides_[i]);
  }
  void speeds_of(const double*, const Vector6d& V, double* v) const override {
    if (turn_ == Turn::any)
      for (int i = 0; i < 3; ++i) v[i] = V(i);
    if (turn_ == Turn::about_z) v[0] = V(2);
    for (int i = 0; i < n_slides(); ++i) v[n_w() + i] = V(3 + slides_[i]);
  }
  void reference(double* q) const override {
    for (int i = 0; i < n_p(); ++i) q[i] = 0.0;
    if (turn_ == Turn::any) q[0] = 1.0;
  }

  void constrain(Rows& rows) const override {
    for (int i = 0; i < 3; ++i)
      if (!slides(i)) rows.position_in_F(Vector3d::Unit(i));
    if (turn_ == Turn::none)
      for (int i = 0; i < 3; ++i) rows.angle(Vector3d::Unit((i + 2) % 3), Vector3d::Unit((i + 1) % 3));
    if (turn_ == Turn::about_z)
      for (int i = 0; i < 2; ++i) rows.angle(Vector3d::Unit(i), Vector3d::UnitZ());
  }
  std::string row_name(int i) const override {
    static const char* axes[] = {"x", "y", "z"};
    for (int k = 0; k < 3; ++k)
      if (!slides(k) && i-- == 0) return axes[k];
    return std::string(turn_ == Turn::none ? "rotation_" : "axis_") + axes[i];
  }

 private:
  int n_q() const { return turn_ == Turn::any ? 4 : turn_ == Turn::about_z ? 1 : 0; }
  int n_w() const { return turn_ == Turn::any ? 3 : n_q(); }
  int n_slides() const { return static_cast<int>(slides_.size()); }
  bool slides(int axis) const {
    for (const int i : slides_)
      if (i == axis) return true;
    return false;
  }
  void add_slides(std::vector<CoordinateInfo>& list, const std::string& prefix,
                  const input::Dimension& dimension) const {
    static const char* axes[] = {"x", "y", "z"};
    for (const int i : slides_) list.push_back({prefix + axes[i], dimension});
  }
  std::vector<CoordinateInfo> rates(const std::string& turning, const std::string& angle,
                                    const std::string& sliding, const input::Dimension& angular,
                                    const input::Dimension& linear) const {
    std::vector<CoordinateInfo> list;
    if (turn_ == Turn::any)
      for (const char* axis : {"x", "y", "z"}) list.push_back({turning + axis, angular});
    if (turn_ == Turn::about_z) list.push_back({angle, angular});
    add_slides(list, sliding, linear);
    return list;
  }

  const char* type_;
  Turn turn_;
  std::vector<int> slides_;
};

/// Mo slides along the z axis of F, M turns freely about it.
inline std::unique_ptr<Joint> point_on_line_joint() {
  return std::make_unique<Partial>("point_on_line", Partial::Turn::any, std::vector<int>{2});
}
/// Mo slides in the xy plane of F, M turns freely about it.
inline std::unique_ptr<Joint> point_on_plane_joint() {
  return std::make_unique<Partial>("point_on_plane", Partial::Turn::any, std::vector<int>{0, 1});
}
/// M moves anywhere but keeps the orientation of F.
inline std::unique_ptr<Joint> orientation_joint() {
  return std::make_unique<Partial>("orientation", Partial::Turn::none, std::vector<int>{0, 1, 2});
}
/// M moves anywhere and turns about z; the z axes stay parallel.
inline std::unique_ptr<Joint> parallel_joint() {
  return std::make_unique<Partial>("parallel", Partial::Turn::about_z, std::vector<int>{0, 1, 2});
}

}  // namespace flexura::mbs
