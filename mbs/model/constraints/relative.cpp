// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/constraint.hpp"

namespace flexura::mbs {

RelativeConstraint::RelativeConstraint(std::string name, int marker_F, int marker_M,
                                       std::shared_ptr<const RelativeRows> rows)
    : Constraint(std::move(name)), marker_F_(marker_F), marker_M_(marker_M), rows_(std::move(rows)) {}

void RelativeConstraint::position(const Kinematics& kin, double* g) const {
  const Pose X = kin.relative_pose(marker_F_, marker_M_);
  const Vector6d at_rest = Vector6d::Zero();
  Rows rows(X, at_rest);
  rows.contact = kin.own.contact;
  rows_->constrain(rows);
  for (int i = 0; i < rows.n; ++i) g[i] = rows.g(i);
}

void RelativeConstraint::velocity(const Kinematics& kin, double* g_dot) const {
  const Relative rel = kin.relative_motion(marker_F_, marker_M_);
  Rows rows(rel.X_FM, rel.V);
  rows.contact = kin.own.contact;
  rows_->constrain(rows);
  for (int i = 0; i < rows.n; ++i) g_dot[i] = rows.G.row(i).dot(rel.V);
}

void RelativeConstraint::acceleration(const Kinematics& kin, double* g_ddot) const {
  const Relative rel = kin.relative_acceleration(marker_F_, marker_M_);
  Rows rows(rel.X_FM, rel.V);
  rows.contact = kin.own.contact;
  rows_->constrain(rows);
  for (int i = 0; i < rows.n; ++i) g_ddot[i] = rows.G.row(i).dot(rel.A) + rows.gamma(i);
}

void RelativeConstraint::apply_GT(const Kinematics& kin, const double* x, Loads& loads) const {
  loads.apply_between(kin, marker_F_, marker_M_, wrench_on_M(kin, x));
}

Vector6d RelativeConstraint::wrench_on_M(const Kinematics& kin, const double* x) const {
  const Pose X = kin.relative_pose(marker_F_, marker_M_);
  const Vector6d at_rest = Vector6d::Zero();
  Rows rows(X, at_rest);
  rows.contact = kin.own.contact;
  rows_->constrain(rows);
  Vector6d on_M = Vector6d::Zero();
  for (int i = 0; i < rows.n; ++i) on_M += x[i] * rows.G.row(i).transpose();
  return on_M;
}

}  // namespace flexura::mbs
