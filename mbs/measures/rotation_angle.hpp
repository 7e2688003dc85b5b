// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>

#include "mbs/measures/measure.hpp"

namespace flexura::mbs {

/// One of the three angles of turns about axes i, j, k that take the marker F to M, each axis turned by those before it:
///
///     R_FM = R_i(q_1) R_j(q_2) R_k(q_3)
///
/// Cardan (Tait-Bryan) angles where i, j, k differ, q_2 within +-90 deg; Euler angles where k = i, q_2 within 0 to 180 deg;
/// the others within +-180 deg.  At the ends of q_2 the other two are not unique.
class RotationAngle final : public Measure {
 public:
  using Sequence = std::array<int, 3>;  ///< axes, 0 to 2; j differs from both
  /// `which`: 0 to 2.
  RotationAngle(std::string name, int F, int M, const Sequence& sequence, int which)
      : Measure(std::move(name)), F_(F), M_(M), axes_(sequence), which_(which) {}
  input::Dimension dimension() const override { return input::dim::angle; }
  double value(const Kinematics& kin, const double*) const override {
    return angles(kin.relative_pose(F_, M_).R)[static_cast<std::size_t>(which_)];
  }
  bool is_of_positions() const override { return true; }
  std::pair<int, int> markers_of_pose() const override { return {F_, M_}; }
  // A small turn of M seen from F is sum q'_n times the n-th axis a_n, turned by those before it:
  // w = A q', w' = A q'' + sum q'_n a_n', a_2' = q'_1 a_1 x a_2, a_3' = w x a_3.
  PoseFunction of_pose(const Relative& rel) const override {
    const Matrix3d& R = rel.X_FM.R;
    const std::array<double, 3> q = angles(R);
    const Vector3d first = Vector3d::Unit(axes_[0]), w = rel.V.head<3>();
    Matrix3d A;
    A << first, Eigen::AngleAxisd(q[0], first) * Vector3d::Unit(axes_[1]), R.col(axes_[2]);
    PoseFunction y{.value = q[static_cast<std::size_t>(which_)]};
    if (A.determinant() == 0.0) return y;
    const Matrix3d inverse = A.inverse();
    const Vector3d q_dot = inverse * w;
    y.gradient.head<3>() = inverse.row(which_).transpose();
    y.bias = -y.gradient.head<3>().dot(q_dot(1) * q_dot(0) * first.cross(Vector3d(A.col(1))) +
                                       q_dot(2) * w.cross(Vector3d(A.col(2))));
    return y;
  }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    Eigen::Matrix<double, 1, 12> row = Eigen::Matrix<double, 1, 12>::Zero();
    row.head<6>() = of_pose(kin.relative_motion(F_, M_)).gradient.transpose();
    d.rows();
    d.by_relative(F_, M_, row);
  }

 private:
  std::array<double, 3> angles(const Matrix3d& R) const {
    const int i = axes_[0], j = axes_[1], k = 3 - i - j;
    const double s = (j - i + 3) % 3 == 1 ? 1.0 : -1.0;  // of the permutation i, j, k
    if (axes_[2] == i)
      return {std::atan2(R(j, i), -s * R(k, i)), std::atan2(std::hypot(R(j, i), R(k, i)), R(i, i)),
              std::atan2(R(i, j), s * R(i, k))};
    return {std::atan2(-s * R(j, k), R(k, k)), std::atan2(s * R(i, k), std::hypot(R(i, i), R(i, j))),
            std::atan2(-s * R(i, j), R(i, i))};
  }

  int F_, M_;
  Sequence axes_;
  int which_;
};

}  // namespace flexura::mbs
