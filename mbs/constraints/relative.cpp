// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>

#include "mbs/constraints/constraint.hpp"
#include "mbs/constraints/pose_hessians.hpp"

namespace flexura::mbs {

RelativeConstraint::RelativeConstraint(std::string name, int marker_F, int marker_M,
                                       std::shared_ptr<const RelativeRows> rows, Prescribed held_at)
    : Constraint(std::move(name)),
      marker_F_(marker_F),
      marker_M_(marker_M),
      rows_(std::move(rows)),
      held_at_(std::move(held_at)),
      exerts_(exerts()) {}

// Asked at poses at which nothing vanishes.
GapKind RelativeConstraint::gap_kind(int row) const {
  if (has_contact()) return GapKind::length;
  Kinematics kin;
  kin.markers.resize(static_cast<std::size_t>(std::max(marker_F_, marker_M_)) + 1);
  kin.markers[static_cast<std::size_t>(marker_M_)].X_WP = {rotation_exp({0.4, -0.7, 1.1}),
                                                           Vector3d(0.9, -0.5, 0.7)};
  const Eigen::VectorXd x = Eigen::VectorXd::Unit(n_rows(), row);
  return wrench_on_M(kin, x.data()).tail<3>().isZero(0.0) ? GapKind::angle : GapKind::length;
}

void RelativeConstraint::position(const Kinematics& kin, double* g) const {
  const Pose X = kin.relative_pose(marker_F_, marker_M_);
  const Vector6d at_rest = Vector6d::Zero();
  Rows rows(X, at_rest);
  rows.contact = kin.own.contact;
  rows_->constrain(rows);
  for (int i = 0; i < rows.n; ++i) g[i] = rows.g(i);
  if (held_at_) g[0] -= held_at_.at(kin).value;
}

void RelativeConstraint::velocity(const Kinematics& kin, double* g_dot) const {
  const Relative rel = kin.relative_motion(marker_F_, marker_M_);
  Rows rows(rel.X_FM, rel.V);
  rows.contact = kin.own.contact;
  rows_->constrain(rows);
  for (int i = 0; i < rows.n; ++i) g_dot[i] = rows.G.row(i).dot(rel.V);
  if (held_at_) g_dot[0] -= held_at_.at(kin).first;
}

void RelativeConstraint::acceleration(const Kinematics& kin, double* g_ddot) const {
  const Relative rel = kin.relative_acceleration(marker_F_, marker_M_);
  Rows rows(rel.X_FM, rel.V);
  rows.contact = kin.own.contact;
  rows_->constrain(rows);
  for (int i = 0; i < rows.n; ++i) g_ddot[i] = rows.G.row(i).dot(rel.A) + rows.gamma(i);
  if (held_at_) g_ddot[0] -= held_at_.at(kin).second;
}

void RelativeConstraint::rate(const Kinematics& kin, double* g_t) const {
  for (int i = 0; i < n_rows(); ++i) g_t[i] = 0.0;
  if (held_at_) g_t[0] = -held_at_.at(kin).first;
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

void RelativeConstraint::differentiate(const Kinematics& kin, const double* x, Derivatives& d) const {
  const Relative rel = kin.relative_motion(marker_F_, marker_M_);
  const auto rows_at = [&](const Vector6d& V) {
    Rows rows(rel.X_FM, V);
    rows.contact = kin.own.contact;
    rows_->constrain(rows);
    return rows;
  };
  // g depends on X_FM alone, and G is the same for every V.
  int n = 0;
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> G;
  const std::array<Matrix6d, 6> H = pose_hessians(
      [&](const Vector6d& V) {
        const Rows rows = rows_at(V);
        n = rows.n;
        G = rows.G;
        return Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1>(rows.gamma.head(n));
      },
      [&](int k) { return Vector6d(G.row(k).transpose()); });
  Vector6d on_M = Vector6d::Zero();
  Eigen::Matrix<double, 6, 12> load = Eigen::Matrix<double, 6, 12>::Zero(), rates = load;
  for (int k = 0; k < n; ++k) {
    on_M += x[k] * G.row(k).transpose();
    load.leftCols<6>() += x[k] * H[k];
    rates.row(k) << rel.V.transpose() * H[k], G.row(k);
  }
  d.between(marker_F_, marker_M_, on_M);
  d.by_relative(marker_F_, marker_M_, load);
  d.rows();
  d.by_relative(marker_F_, marker_M_, rates.topRows(n));
}

void RelativeConstraint::differentiate_contact(const Kinematics& kin, double a, Derivatives& d) const {
  const Eigen::Vector4d by = rows_->contact_derivatives(kin.relative_pose(marker_F_, marker_M_), a);
  Eigen::Matrix<double, 1, 12> row = Eigen::Matrix<double, 1, 12>::Zero();
  row.segment<3>(3) = by.head<3>().transpose();
  d.rows();
  d.by_relative(marker_F_, marker_M_, row);
  d.by_algebraic(by(3));
}

}  // namespace flexura::mbs
