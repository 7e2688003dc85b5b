// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/constraints/constraint.hpp"

/// What constraints exert, by name.  The generalised forces of a constraint with multipliers x are -G^T x.
namespace flexura::mbs {

namespace dim = input::dim;

std::vector<OutputInfo> Constraint::outputs() const {
  std::vector<OutputInfo> infos;
  for (int i = 0; i < n_rows(); ++i)
    infos.push_back({"force_" + row_name(i), dim::none,
                     "generalised force along this row: its power is the force times the row's rate"});
  return infos;
}

void Constraint::evaluate_outputs(const Kinematics&, const double* x, double* values) const {
  for (int i = 0; i < n_rows(); ++i) values[i] = -x[i];
}

std::vector<OutputInfo> wrench_outputs(bool has_force, bool has_torque) {
  std::vector<OutputInfo> infos;
  if (has_force) infos.push_back({"force", dim::force, "size of the force between the bodies"});
  if (has_torque) infos.push_back({"torque", dim::torque, "size of the torque between the bodies"});
  const std::string axes[] = {"x", "y", "z"};
  for (int i = 0; has_force && i < 3; ++i)
    infos.push_back(
        {"force_" + axes[i], dim::force, "force on the body of `to`, in the axes of the marker `from`"});
  for (int i = 0; has_torque && i < 3; ++i)
    infos.push_back({"torque_" + axes[i], dim::torque,
                     "torque on the body of `to` about its marker, in the axes of the marker `from`"});
  return infos;
}

void put_wrench(const Vector6d& on_M_F, bool has_force, bool has_torque, double* values) {
  const Vector3d torque = on_M_F.head<3>(), force = on_M_F.tail<3>();
  if (has_force) *values++ = force.norm();
  if (has_torque) *values++ = torque.norm();
  for (int i = 0; has_force && i < 3; ++i) *values++ = force(i);
  for (int i = 0; has_torque && i < 3; ++i) *values++ = torque(i);
}

// Rows on positions in F put no torque on Mo, rows on angles no force: seen at a pose without symmetries.
RelativeConstraint::Exerts RelativeConstraint::exerts() const {
  const Pose X{(Eigen::AngleAxisd(0.7, Vector3d(0.3, 0.5, 0.8).normalized())).toRotationMatrix(),
               {0.31, 0.53, 0.73}};
  const Vector6d at_rest = Vector6d::Zero();
  Rows rows(X, at_rest);
  rows_->constrain(rows);
  Exerts out;
  for (int i = 0; i < rows.n; ++i) {
    out.torque = out.torque || !rows.G.row(i).head<3>().isZero(0.0);
    out.force = out.force || !rows.G.row(i).tail<3>().isZero(0.0);
  }
  return out;
}

std::vector<OutputInfo> RelativeConstraint::outputs() const {
  std::vector<OutputInfo> infos = wrench_outputs(exerts_.force, exerts_.torque);
  if (rows_->is_link())
    infos.push_back({"tension", dim::force, "of the link: positive where it pulls its ends together"});
  return infos;
}

void RelativeConstraint::evaluate_outputs(const Kinematics& kin, const double* x, double* values) const {
  const Vector6d on_M = -wrench_on_M(kin, x);
  put_wrench(on_M, exerts_.force, exerts_.torque, values);
  if (rows_->is_link())
    values[outputs().size() - 1] =
        -on_M.tail<3>().dot(kin.relative_pose(marker_F_, marker_M_).p.normalized());
}

}  // namespace flexura::mbs
