// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/constraints/rotation_drive.hpp"

#include "mbs/base/math/rotation_sequences.hpp"

namespace flexura::mbs {

PrescribedRotation::Jets PrescribedRotation::jets(const Kinematics& kin) const {
  Jets q;
  for (std::size_t i = 0; i < 3; ++i) q[i] = q_[i].at(kin, static_cast<int>(i));
  return q;
}

DrivenRotation PrescribedRotation::at_time(double t) const {
  Jets q;
  for (std::size_t i = 0; i < 3; ++i) q[i] = q_[i].formula()->time_derivatives(t);
  return of(q);
}

DrivenRotation PrescribedRotation::of(const Jets& q) const {
  const Vector3d values(q[0].value, q[1].value, q[2].value), second(q[0].second, q[1].second, q[2].second);
  const auto [w, bias] = turn(q, {q[0].first, q[1].first, q[2].first});
  const Vector3d by_second = turn(q, second).first;
  return {axes_ ? rotation_by_angles(*axes_, values) : rotation_exp(values), w, by_second + bias};
}

std::pair<Vector3d, Vector3d> PrescribedRotation::turn(Jets q, const Vector3d& q_dot) const {
  if (!axes_) {
    const Vector3d theta(q[0].value, q[1].value, q[2].value);
    return {left_jacobian(theta) * q_dot, left_jacobian_bias(theta, q_dot)};
  }
  // Each axis turns with the turns before it: a' = w x a.
  Vector3d w = Vector3d::Zero(), bias = w;
  Matrix3d R = Matrix3d::Identity();
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3d axis = Vector3d::Unit((*axes_)[i]), a = R * axis;
    const auto k = static_cast<Eigen::Index>(i);
    bias += q_dot(k) * w.cross(a);
    w += q_dot(k) * a;
    R = R * Eigen::AngleAxisd(q[i].value, axis).toRotationMatrix();
  }
  return {w, bias};
}

Matrix3d PrescribedRotation::by_rates(const Kinematics& kin) const {
  const Jets q = jets(kin);
  Matrix3d A;
  for (int i = 0; i < 3; ++i) A.col(i) = turn(q, Vector3d::Unit(i)).first;
  return A;
}

// A' q' is quadratic in q', and its polarisation d_i A q' + sum_j q'_j d_j A_i, A_i the columns of A.  As turns do not
// commute d_i A_j - d_j A_i = A_i x A_j, which parts the two.
Matrix3d PrescribedRotation::by_angles(const Kinematics& kin) const {
  const Jets q = jets(kin);
  const Vector3d q_dot(q[0].first, q[1].first, q[2].first);
  const auto [w, bias] = turn(q, q_dot);
  Matrix3d out;
  for (int i = 0; i < 3; ++i) {
    const auto [a, own] = turn(q, Vector3d::Unit(i));
    const Vector3d both = turn(q, q_dot + Vector3d::Unit(i)).second - bias - own;
    out.col(i) = 0.5 * (both + a.cross(w));
  }
  return out;
}

Following RotationDrive::following(int i) const {
  const Prescribed& q = rotation_.angles()[static_cast<std::size_t>(i)];
  return q.follows() ? Following{q.formula().get(), DriveLevel::position} : Following{};
}

void RotationDrive::by_followed(const Kinematics& kin, int i, double* g_y, double* h_y,
                                double* h_y_dot) const {
  const Vector3d a = rotation_.by_rates(kin).col(i), w_i = rotation_.by_angles(kin).col(i);
  for (int k = 0; k < 3; ++k) {
    g_y[k] = h_y_dot[k] = -a(k);
    h_y[k] = -w_i(k);
  }
}

void RotationDrive::position(const Kinematics& kin, double* g) const {
  const Vector3d ahead =
      rotation_log(kin.relative_pose(marker_F_, marker_M_).R * rotation_.at(kin).R.transpose());
  for (int i = 0; i < 3; ++i) g[i] = ahead(i);
}

void RotationDrive::velocity(const Kinematics& kin, double* g_dot) const {
  const Vector3d w = rotation_.at(kin).w;
  for (int i = 0; i < 3; ++i) g_dot[i] = kin.speed({joint_, i}) - w(i);
}

void RotationDrive::acceleration(const Kinematics& kin, double* g_ddot) const {
  const Vector3d alpha = rotation_.at(kin).alpha;
  for (int i = 0; i < 3; ++i) g_ddot[i] = kin.acceleration({joint_, i}) - alpha(i);
}

void RotationDrive::rate(const Kinematics& kin, double* g_t) const {
  const Vector3d w = rotation_.at(kin).w;
  for (int i = 0; i < 3; ++i) g_t[i] = -w(i);
}

void RotationDrive::apply_GT(const Kinematics&, const double* x, Loads& loads) const {
  for (int i = 0; i < 3; ++i) loads.apply({joint_, i}, x[i]);
}

void RotationDrive::differentiate(const Kinematics&, const double* x, Derivatives& d) const {
  for (int i = 0; i < 3; ++i) d.force({joint_, i}, x[i]);
  d.rows();
  for (int i = 0; i < 3; ++i) d.by_speed({joint_, i}, Vector3d(Vector3d::Unit(i)));
}

}  // namespace flexura::mbs
