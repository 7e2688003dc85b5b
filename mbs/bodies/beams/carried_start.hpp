// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "beam/exact/element.hpp"
#include "mbs/bodies/flexible_body.hpp"

/// Between the axes of the section that a geometrically exact beam starts with, in which it is described, and those of its body B
/// about Bo: `start` is the section's place and axes in B.
namespace flexura::mbs {

/// Angular and linear columns, turned.
template <class Columns>
void turn_columns(const Matrix3d& R, Columns& x) {
  for (Eigen::Index j = 0; j < x.cols(); ++j) {
    const Vector3d w = R * x.col(j).template head<3>(), v = R * x.col(j).template tail<3>();
    x.col(j) << w, v;
  }
}

/// V and A of B.
inline beam::exact::Element::Carried carried_start(const Spatial& V, const Spatial& A, const Pose& start) {
  const Vector3d &w = V.angular, &alpha = A.angular, &p = start.p;
  const auto to_start = start.R.transpose();
  return {to_start * w, to_start * alpha, to_start * (A.linear + alpha.cross(p) + w.cross(w.cross(p)))};
}

inline Spatial wrench_about_origin(const Vector6d& at_start, const Pose& start) {
  const Vector3d force = start.R * at_start.tail<3>();
  return {start.R * at_start.head<3>() + start.p.cross(force), force};
}

/// The integrals of `out` from those about the start.
inline void take_about_origin(const beam::exact::Element::Integrals& at, double mass, const Pose& start,
                              FlexibleBody::Scratch& out) {
  const Matrix3d& R = start.R;
  const Vector3d &p = start.p, d = R * at.d;
  out.d = mass * p + d;
  out.J = R * at.J * R.transpose() + (mass * p.squaredNorm() + 2.0 * p.dot(d)) * Matrix3d::Identity() -
          mass * p * p.transpose() - p * d.transpose() - d * p.transpose();
  out.C_t.noalias() = R * at.C_t;
  out.C_r.noalias() = R * at.C_r;
  out.C_r.noalias() += skew(p) * out.C_t;
}

/// 6 x m wrenches.
inline void columns_about_origin(const beam::exact::Element::Columns& from, const Pose& start,
                                 DeformationTangents::Columns& to) {
  to.bottomRows<3>().noalias() = start.R * from.bottomRows<3>();
  to.topRows<3>().noalias() = start.R * from.topRows<3>();
  to.topRows<3>().noalias() += skew(start.p) * to.bottomRows<3>();
}

/// By w at the start (`by_w`, and `modal_w` in its axes), and by the start's acceleration w x (w x p).
inline void turning_about_origin(const beam::exact::Element::Integrals& at, double mass, const Pose& start,
                                 const Vector3d& w, Eigen::Matrix<double, 6, 3>& by_w,
                                 Eigen::Matrix<double, 6, 3>& need_w, FlexibleBody::Modal3& modal_w) {
  const Matrix3d& R = start.R;
  const Vector3d& p = start.p;
  turn_columns(R, by_w);
  const Matrix3d p_w = -(skew(w.cross(p)) + skew(w) * skew(p));  // of w x (w x p) by w
  const Matrix3d force = by_w.bottomRows<3>() * R.transpose() + mass * p_w;
  need_w.bottomRows<3>() = force;
  need_w.topRows<3>() = by_w.topRows<3>() * R.transpose() + skew(R * at.d) * p_w + skew(p) * force;
  modal_w = (modal_w * R.transpose() + at.C_t.transpose() * R.transpose() * p_w).eval();
}

}  // namespace flexura::mbs
