// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "mbs/constraints/constraint.hpp"

/// Constraints that are one or more rows on the pose of marker M in marker F.
namespace flexura::mbs {

/// Mo stays on the z axis of F.
class PointOnLine final : public RelativeRows {
 public:
  int n_rows() const override { return 2; }
  void constrain(Rows& rows) const override {
    for (int i = 0; i < 2; ++i) rows.position_in_F(Vector3d::Unit(i));
  }
  std::string row_name(int i) const override { return i == 0 ? "x" : "y"; }
};

/// Mo stays in the xy plane of F.
class PointOnPlane final : public RelativeRows {
 public:
  int n_rows() const override { return 1; }
  void constrain(Rows& rows) const override { rows.position_in_F(Vector3d::UnitZ()); }
  std::string row_name(int) const override { return "z"; }
};

/// M keeps the orientation of F.
class Orientation final : public RelativeRows {
 public:
  int n_rows() const override { return 3; }
  void constrain(Rows& rows) const override {
    for (int i = 0; i < 3; ++i) rows.angle(Vector3d::Unit((i + 2) % 3), Vector3d::Unit((i + 1) % 3));
  }
  std::string row_name(int i) const override {
    static const char* names[] = {"rotation_x", "rotation_y", "rotation_z"};
    return names[i];
  }
};

/// The z axes stay parallel.
class Parallel final : public RelativeRows {
 public:
  int n_rows() const override { return 2; }
  void constrain(Rows& rows) const override {
    for (int i = 0; i < 2; ++i) rows.angle(Vector3d::Unit(i), Vector3d::UnitZ());
  }
  std::string row_name(int i) const override { return i == 0 ? "axis_x" : "axis_y"; }
};

/// The z axes stay perpendicular.
class Perpendicular final : public RelativeRows {
 public:
  int n_rows() const override { return 1; }
  void constrain(Rows& rows) const override { rows.angle(Vector3d::UnitZ(), Vector3d::UnitZ()); }
  std::string row_name(int) const override { return "axes"; }
};

/// How far the origins are apart, for a distance that changes: g = |p_FoMo|, less what RelativeConstraint holds it at.
class Span final : public RelativeRows {
 public:
  int n_rows() const override { return 1; }
  void constrain(Rows& rows) const override {
    const Vector3d& p = rows.X_FM().p;
    const double length = std::max(p.norm(), 1e-300);
    const Vector3d n = p / length, u = rows.linear();
    rows.add(p.norm(), Vector3d::Zero(), n, (u.squaredNorm() - n.dot(u) * n.dot(u)) / length);
  }
  std::string row_name(int) const override { return "length"; }
  bool is_link() const override { return true; }
};

/// The origins keep their distance, as if joined by a massless link with ball joints.
class Distance final : public RelativeRows {
 public:
  explicit Distance(double length) : length_(length) {}
  int n_rows() const override { return 1; }
  void constrain(Rows& rows) const override { rows.distance(length_); }
  // Of g = (d^2 - L^2) / 2 L the gap is d - L.
  double gap(int, double g) const override {
    return std::sqrt(std::max(0.0, length_ * (length_ + 2.0 * g))) - length_;
  }
  std::string row_name(int) const override { return "length"; }
  bool is_link() const override { return true; }

 private:
  double length_;
};

}  // namespace flexura::mbs
