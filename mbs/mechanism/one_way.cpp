// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "mbs/base/math/differences.hpp"
#include "mbs/mechanism/work.hpp"

/// One-way deformation (kineto-elastodynamics): the mechanism moves with the body rigid, and the deformation
/// answers to that motion,
///
///     s'' = -( D s' + K s + C_t^T (a - g) + C_r^T alpha + centrifugal and Coriolis terms - Phi^T F ),
///
/// F all loads on the body's interfaces, joint reactions of the rigid motion included.  It is right as long
/// as the deformation does not change the motion, and its states lie behind those of the mechanism (p, v,
/// lambda do not depend on them).
namespace flexura::mbs {

void Mechanism::one_way_loads(int b, const Spatial& V, const Spatial& A, Work& work) const {
  const FlexibleBody& body = *d_.bodies[b].ked;
  Work::Body& at = work.bodies[b];
  const double* s = work.kin.c + bodies_[b].i_c;
  const double* s_dot = s + body.m();
  body.set_position(s, at.flexible);
  // Without modal accelerations: the modes are mass-normalised, so that what is needed is -s''.
  at.no_acceleration.setZero(body.m());
  body.inverse_dynamics(s, s_dot, at.no_acceleration.data(), V, A, at.flexible, at.one_way.data());
}

void Mechanism::load_one_way(int marker, const Spatial& wrench_W, double factor, Work& work) const {
  const MarkerDescription& description = d_.markers[marker];
  Work::Body& body = work.bodies[description.body];
  const FlexibleNode& node = d_.bodies[description.body].ked->data().nodes[description.ked_node];
  const Spatial in_B = body.X_WB.R.transpose() * wrench_W;
  const Spatial at_node = shift_wrench(in_B, description.X_BP.p - node.p_BoN_B);
  body.one_way.noalias() -= factor * (node.Phi_r.transpose() * at_node.angular);
  body.one_way.noalias() -= factor * (node.Phi_t.transpose() * at_node.linear);
}

void Mechanism::one_way_rates(const Work& work, double* c_rate) const {
  for (int b : order_) {
    if (!d_.bodies[b].ked) continue;
    const int m = d_.bodies[b].ked->m(), i = bodies_[b].i_c;
    for (int k = 0; k < m; ++k) {
      c_rate[i + k] = work.kin.c[i + m + k];
      c_rate[i + m + k] = -work.bodies[b].one_way(k);
    }
  }
}

// By the deformation itself, after body_forces().
void Mechanism::one_way_tangents(Work& work, Eigen::MatrixXd& z_c) const {
  for (int b : order_) {
    if (!d_.bodies[b].ked) continue;
    const FlexibleBody& ked = *d_.bodies[b].ked;
    const int m = ked.m(), i = bodies_[b].i_c;
    Work::Body& body = work.bodies[b];
    DeformationTangents& d = work.tangent.deformations[b];
    const Matrix3d& R = body.X_WB.R;
    const double* s = work.kin.c + i;
    ked.deformation_tangents(s, s + m, body.no_acceleration.data(), R.transpose() * body.V,
                             R.transpose() * Spatial{body.A.angular, body.A.linear - d_.gravity},
                             body.flexible, d);
    z_c.block(n_v_ + i, i + m, m, m).setIdentity();
    z_c.block(n_v_ + i + m, i, m, m) = -d.modal_s;
    z_c.block(n_v_ + i + m, i + m, m, m) = -d.modal_v;
  }
}

// By the motion and by the states of others: central differences, of which rigid bodies have few.  By
// accelerations and reactions, which act linearly, unit steps are exact.
void Mechanism::difference_one_way(const State& s, ConstVectorRef v_dot, Work& work,
                                   TangentMatrices& out) const {
  const int first = first_force_state_.back(), n = n_dyn_ - first;
  if (n == 0) return;
  Work::Tangent& T = work.tangent;
  State& moved = T.moved;
  moved = s;
  const auto evaluate = [&](ConstVectorRef at_v_dot, Eigen::VectorXd& z) {
    momentum(moved, at_v_dot, work, z.head(n_v_), z.segment(n_v_, n_dyn_), z.tail(z.size() - n_v_ - n_dyn_));
  };
  const auto change = [&](double step) { return (T.z_plus - T.z).segment(n_v_ + first, n) / step; };
  for (int j = 0; j < n_v_; ++j) {
    T.step(j) = kCentralStep;
    retract(s.p, T.step, moved.p);
    evaluate(v_dot, T.z_plus);
    T.step(j) = -kCentralStep;
    retract(s.p, T.step, moved.p);
    evaluate(v_dot, T.z);
    T.step(j) = 0.0;
    moved.p = s.p;
    T.z_q.col(j).segment(n_v_ + first, n) = change(2.0 * kCentralStep);
  }
  const auto along = [&](Eigen::VectorXd& x, Eigen::Index j, auto&& column) {
    const double x_j = x(j), step = kCentralStep * std::max(1.0, std::abs(x_j));
    x(j) = x_j + step;
    evaluate(v_dot, T.z_plus);
    x(j) = x_j - step;
    evaluate(v_dot, T.z);
    x(j) = x_j;
    column.segment(n_v_ + first, n) = change(2.0 * step);
  };
  for (int j = 0; j < n_v_; ++j) along(moved.v, j, out.z_v.col(j));
  for (int j = 0; j < first; ++j) along(moved.c, j, out.z_c.col(j));
  for (Eigen::Index j = 0; j < s.a.size(); ++j) along(moved.a, j, out.z_a.col(j));

  out.c_v_dot.setZero(n_dyn_, n_v_);
  out.c_lambda.setZero(n_dyn_, s.lambda.size());
  evaluate(v_dot, T.z);
  T.step = v_dot;
  for (int j = 0; j < n_v_; ++j) {
    T.step(j) += 1.0;
    evaluate(T.step, T.z_plus);
    T.step(j) = v_dot(j);
    out.c_v_dot.col(j).tail(n) = change(1.0);
  }
  T.step.setZero();
  for (Eigen::Index k = 0; k < s.lambda.size(); ++k) {
    moved.lambda(k) += 1.0;
    evaluate(v_dot, T.z_plus);
    moved.lambda(k) = s.lambda(k);
    out.c_lambda.col(k).tail(n) = change(1.0);
  }
}

void Mechanism::deform_one_way_markers(Work& work) const {
  for (std::size_t i = 0; i < d_.markers.size(); ++i) {
    const MarkerDescription& description = d_.markers[i];
    if (description.ked_node < 0) continue;
    const Work::Body& body = work.bodies[description.body];
    const FlexibleBody& ked = *d_.bodies[description.body].ked;
    const FlexibleNode& node = ked.data().nodes[description.ked_node];
    const double* s = work.kin.c + bodies_[description.body].i_c;
    const Eigen::Map<const Eigen::VectorXd> s_dot(s + ked.m(), ked.m());
    const Pose X_BP =
        ked.node_pose(description.ked_node, s) * Pose{description.X_BP.R, description.X_BP.p - node.p_BoN_B};
    const Vector3d w_B = node.Phi_r * s_dot, v_B = node.Phi_t * s_dot + w_B.cross(X_BP.p - node.p_BoN_B);
    MarkerState& marker = work.kin.markers[i];
    marker.X_WP = body.X_WB * X_BP;
    const Vector3d r = marker.X_WP.p - body.X_WB.p;
    marker.V.angular = body.V.angular + body.X_WB.R * w_B;
    marker.V.linear = body.V.linear + body.V.angular.cross(r) + body.X_WB.R * v_B;
  }
}

}  // namespace flexura::mbs
