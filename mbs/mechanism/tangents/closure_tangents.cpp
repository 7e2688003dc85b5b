// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/tangents/closure_tangents.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "mbs/base/math/differences.hpp"

namespace flexura::mbs {

Eigen::Matrix<double, 1, 12> closure_gradient(const Kinematics& kin, const JointPlace& place, int index,
                                              bool of_speed) {
  constexpr double h = kCentralStep;
  const Relative rel = kin.relative_motion(place.marker_F, place.marker_M);
  Eigen::Matrix<double, 1, 12> gradient;
  for (int j = 0; j < (of_speed ? 12 : 6); ++j) {
    double value[2], q[7], v[6];
    for (int k = 0; k < 2; ++k) {
      Relative moved = rel;
      const double step = k == 0 ? h : -h;
      if (j < 3)
        moved.X_FM.R = rotation_exp(step * Vector3d::Unit(j)) * rel.X_FM.R;
      else if (j < 6)
        moved.X_FM.p(j - 3) += step;
      else
        moved.V(j - 6) += step;
      place.joint->coordinates_of(moved.X_FM, q);
      if (of_speed) place.joint->speeds_of(q, moved.V, v);
      value[k] = of_speed ? v[index] : q[index];
    }
    double change = value[0] - value[1];
    if (std::abs(change) > 1.0) change = std::remainder(change, 2.0 * std::numbers::pi);  // across +-pi
    gradient(j) = change / (2.0 * h);
  }
  if (!of_speed) gradient.tail<6>().setZero();
  return gradient;
}

Vector6d closure_wrench(const Joint& joint, const Pose& X_FM, int index) {
  double q[7];
  joint.coordinates_of(X_FM, q);
  MotionMatrix S = MotionMatrix::Zero(6, joint.n_v());
  joint.motion(q, S);
  const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> gram = S.transpose() * S;
  return S * gram.inverse().col(index);
}

Eigen::Matrix<double, 6, 12> closure_wrench_gradient(const Joint& joint, const Pose& X_FM, int index) {
  constexpr double h = kCentralStep;
  Eigen::Matrix<double, 6, 12> turned = Eigen::Matrix<double, 6, 12>::Zero();
  for (int j = 0; j < 6; ++j)
    for (const double sign : {1.0, -1.0}) {
      Pose moved = X_FM;
      if (j < 3)
        moved.R = rotation_exp(sign * h * Vector3d::Unit(j)) * X_FM.R;
      else
        moved.p(j - 3) += sign * h;
      turned.col(j) += sign / (2.0 * h) * closure_wrench(joint, moved, index);
    }
  return turned;
}

}  // namespace flexura::mbs
