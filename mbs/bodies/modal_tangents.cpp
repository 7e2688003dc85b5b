// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/math/rotation.hpp"
#include "mbs/bodies/modal_body.hpp"

/// Derivatives of what a modal body needs and of how its nodes move, by its coordinates s and s'.
///
/// With Phi_l a mode and B_ab,l = int rho_a Phi_l,b (modal_body.hpp), T_ba = T_ab^T and N_ab symmetric
/// give
///
///     d(int rho_a rho_b)/ds_l = B_ba,l + B_ab,l      dP_ab/ds_l = (T_ba s' + N_ab s')_l      dd/ds_l = C_t,l
namespace flexura::mbs {
namespace {

using ConstMap = Eigen::Map<const Eigen::VectorXd>;

}  // namespace

void ModalBody::deformation_tangents(const double*, const double* s_dot_values, const double* s_ddot_values,
                                     const Spatial& V, const Spatial& A, Scratch& scratch,
                                     DeformationTangents& out) const {
  const Work& work = static_cast<const Work&>(scratch);
  const ConstMap s_dot(s_dot_values, m_), s_ddot(s_ddot_values, m_);
  const Vector3d &w = V.angular, &alpha = A.angular, &a = A.linear;
  const bool full = data_.coupling == Coupling::full, varies = data_.coupling != Coupling::constant;
  const auto B = [&](int i, int j, int l) { return work.B((3 * i + j) * m_ + l); };

  out.modal_s = data_.stiffness.asDiagonal();
  out.modal_v = data_.damping.asDiagonal();
  if (data_.damping_coupling.size() > 0) out.modal_v += data_.damping_coupling;
  Matrix3d Q = w * w.transpose() - w.squaredNorm() * Matrix3d::Identity();
  if (full) {
    out.T_v.noalias() = T_ * s_dot;
    for (int c = 0; c < 3; ++c) {
      const auto T_skew = T_skew_.middleRows(c * m_, m_);
      out.turn.segment(c * m_, m_).noalias() = -T_skew * s_ddot;
      out.modal_s += alpha(c) * T_skew;
      out.modal_v += 2.0 * w(c) * T_skew;
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) out.modal_s += Q(i, j) * T_.middleRows((3 * i + j) * m_, m_);
  }
  for (int l = 0; l < m_; ++l) {
    const Vector3d C_t = work.C_t.col(l), C_r = work.C_r.col(l);
    Spatial by_s, by_v;
    by_s.linear = alpha.cross(C_t) + w.cross(w.cross(C_t));
    by_s.angular = C_t.cross(a);
    by_v.linear = 2.0 * w.cross(C_t);
    if (!varies) {
      by_v.angular = w.cross(C_r);
    } else {
      Matrix3d rho_rho, P;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          rho_rho(i, j) = B(j, i, l) + B(i, j, l);
          P(i, j) = B(i, j, l);
        }
      const Matrix3d J = rho_rho.trace() * Matrix3d::Identity() - rho_rho;
      by_s.angular += J * alpha + w.cross(J * w);
      by_v.angular = 2.0 * (w * P.trace() - P.transpose() * w);
    }
    if (full) {
      Matrix3d P;
      for (int i = 0; i < 3; ++i) {
        by_s.angular(i) += out.turn(i * m_ + l);
        for (int j = 0; j < 3; ++j) P(i, j) = out.T_v((3 * j + i) * m_ + l);
      }
      by_s.angular += 2.0 * (w * P.trace() - P.transpose() * w);
    }
    out.need_s.col(l) = by_s.vector();
    out.need_v.col(l) = by_v.vector();
  }
  if (!data_.second) return;
  // What the second-order displacement adds.
  const auto &t = data_.second->t, &x = data_.second->x;
  for (int c = 0; c < 3; ++c) {
    out.modal_s += a(c) * t.middleRows(c * m_, m_) + alpha(c) * N_skew_.middleRows(c * m_, m_);
    for (int j = 0; j < 3; ++j) out.modal_s += Q(c, j) * x.middleRows((3 * c + j) * m_, m_);
  }
  for (int l = 0; l < m_; ++l) {
    Vector3d t_v, t_a, turn_v, turn_a;
    Matrix3d P;
    for (int c = 0; c < 3; ++c) {
      t_v(c) = t.row(c * m_ + l).dot(s_dot);
      t_a(c) = t.row(c * m_ + l).dot(s_ddot);
      turn_v(c) = N_skew_.row(c * m_ + l).dot(s_dot);
      turn_a(c) = N_skew_.row(c * m_ + l).dot(s_ddot);
      for (int j = 0; j < 3; ++j) P(c, j) = x.row((3 * c + j) * m_ + l).dot(s_dot);
    }
    out.need_s.col(l).head<3>() += turn_a + 2.0 * (w * P.trace() - P.transpose() * w);
    out.need_s.col(l).tail<3>() += 2.0 * w.cross(t_v) + t_a;
    out.need_v.col(l).head<3>() += 2.0 * turn_v;
    out.need_v.col(l).tail<3>() += 2.0 * t_v;
  }
}

void ModalBody::node_tangents(int index, const double* s_values, const double* s_dot_values,
                              const double* s_ddot_values, const Vector6d& wrench,
                              DeformationTangents& out) const {
  // u' = map_t s', theta' = theta_map s', w = J theta'; theta and u are quadratic in s at most.
  const FlexibleNode& node = data_.nodes[index];
  const ConstMap s(s_values, m_), s_dot(s_dot_values, m_), s_ddot(s_ddot_values, m_);
  const bool second = node.second.size() > 0;
  Vector3d theta = Vector3d::Zero(), rate = Vector3d::Zero(), acceleration = Vector3d::Zero();
  const auto theta_map = [&](int l) {
    Vector3d x = node.Phi_r.col(l);
    if (second)
      for (int k = 0; k < 3; ++k) x(k) += node.second.row((3 + k) * m_ + l).dot(s);
    return x;
  };
  // theta'' is that of s'' and of the curvature s'^T second s'.
  Vector3d curved = Vector3d::Zero();
  for (int l = 0; l < m_; ++l) {
    const Vector3d x = theta_map(l);
    theta += s(l) * 0.5 * (x + node.Phi_r.col(l));
    rate += s_dot(l) * x;
    acceleration += s_ddot(l) * x;
    if (second)
      for (int k = 0; k < 3; ++k) curved(k) += s_dot(l) * node.second.row((3 + k) * m_ + l).dot(s_dot);
  }
  const LeftJacobian J(theta);
  const Vector3d f = wrench.tail<3>(), torque = wrench.head<3>();
  Matrix3d Y;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) Y(i, j) = J.first(Vector3d::Unit(i), Vector3d::Unit(j)).dot(torque);
  Vector3d J_torque;  // J^T torque
  for (int i = 0; i < 3; ++i) J_torque(i) = J(Vector3d::Unit(i)).dot(torque);
  for (int l = 0; l < m_; ++l) {
    const Vector3d x = theta_map(l);
    // Second derivatives of u and theta by s_l and along s', s''.
    Vector3d u_v = Vector3d::Zero(), u_a = u_v, theta_v = u_v, theta_a = u_v;
    if (second)
      for (int k = 0; k < 3; ++k) {
        u_v(k) = node.second.row(k * m_ + l).dot(s_dot);
        u_a(k) = node.second.row(k * m_ + l).dot(s_ddot);
        theta_v(k) = node.second.row((3 + k) * m_ + l).dot(s_dot);
        theta_a(k) = node.second.row((3 + k) * m_ + l).dot(s_ddot);
      }
    out.motion_s.col(l) << J.first(x, rate) + J(theta_v), u_v;
    out.acceleration_s.col(l) << J.first(x, acceleration + curved) + J(theta_a) + J.second(x, rate, rate) +
                                     J.first(theta_v, rate) + J.first(rate, theta_v),
        u_a;
    out.acceleration_v.col(l) << J.first(x, rate) + J.first(rate, x) + 2.0 * J(theta_v), 2.0 * u_v;
    for (int i = 0; i < m_; ++i) {
      double sum = x.dot(Y * theta_map(i));
      if (second)
        for (int k = 0; k < 3; ++k)
          sum += node.second(k * m_ + i, l) * f(k) + node.second((3 + k) * m_ + i, l) * J_torque(k);
      out.map_s(i, l) = sum;
    }
  }
}

}  // namespace flexura::mbs
