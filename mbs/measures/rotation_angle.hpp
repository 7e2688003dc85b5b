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
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    // A small turn of M seen from F is sum q'_n times the n-th axis, turned by those before it.
    const Matrix3d R = kin.relative_pose(F_, M_).R;
    const std::array<double, 3> q = angles(R);
    const Vector3d first = Vector3d::Unit(axes_[0]);
    Matrix3d turned;
    turned << first, Eigen::AngleAxisd(q[0], first) * Vector3d::Unit(axes_[1]), R.col(axes_[2]);
    Eigen::Matrix<double, 1, 12> row = Eigen::Matrix<double, 1, 12>::Zero();
    if (turned.determinant() != 0.0) row.head<3>() = turned.inverse().row(which_);
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
