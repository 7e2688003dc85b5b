// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "mbs/base/math/differences.hpp"
#include "mbs/mechanism/work.hpp"

/// Deformations that follow the motion without acting back on it (FlexibleBody::acts_back): the mechanism moves with the
/// body rigid, and of what inverse_dynamics() asks for and of all loads on the body's nodes, joint reactions included,
/// follows s''.  Their states (s, s') lie behind those of the elements (p, v, lambda do not depend on them).
namespace flexura::mbs {

void Mechanism::following_need(int b, const Spatial& V, const Spatial& A, Work& work) const {
  const FlexibleBody& flexible = *d_.bodies[b].flexible;
  const TreeBody& t = bodies_[b];
  Work::Body& body = work.bodies[b];
  const double* s = work.kin.c + t.i_c;
  flexible.set_position(s, *body.flexible);
  flexible.inverse_dynamics(s, s + t.n_need, body.no_acceleration.data(), V, A, *body.flexible,
                            work.r.data() + t.i_need);
}

void Mechanism::following_rates(const Work& work, double* c_rate) const {
  for (int b : order_) {
    const TreeBody& t = bodies_[b];
    if (t.i_c < 0) continue;
    const int m = t.n_need, i = t.i_c;
    for (int k = 0; k < m; ++k) {
      c_rate[i + k] = work.kin.c[i + m + k];
      c_rate[i + m + k] = -work.r(t.i_need + k);
    }
  }
}

// By the deformation itself, after body_forces().
void Mechanism::following_tangents(Work& work, Eigen::MatrixXd& z_c) const {
  for (int b : order_) {
    if (bodies_[b].i_c < 0) continue;
    const int m = bodies_[b].n_need, i = bodies_[b].i_c;
    Work::Body& body = work.bodies[b];
    DeformationTangents& d = work.tangent.deformations[b];
    const Matrix3d& R = body.X_WB.R;
    const double* s = work.kin.c + i;
    d_.bodies[b].flexible->deformation_tangents(s, s + m, body.no_acceleration.data(), R.transpose() * body.V,
                                                R.transpose() * Spatial{body.A.angular, body.A.linear - d_.gravity},
                                                *body.flexible, d);
    z_c.block(n_v_ + i, i + m, m, m).setIdentity();
    z_c.block(n_v_ + i + m, i, m, m) = -d.modal_s;
    z_c.block(n_v_ + i + m, i + m, m, m) = -d.modal_v;
  }
}

// By the motion and by the states of others: central differences, of which rigid bodies have few.  By
// accelerations and reactions, which act linearly, unit steps are exact.
void Mechanism::difference_following(const State& s, ConstVectorRef v_dot, Work& work,
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

void Mechanism::deform_following_markers(Work& work) const {
  for (std::size_t i = 0; i < d_.markers.size(); ++i) {
    if (!on_node_[i] || is_carried_[i]) continue;
    const MarkerDescription& description = d_.markers[i];
    const Work::Body& body = work.bodies[description.body];
    const FlexibleBody& flexible = *d_.bodies[description.body].flexible;
    const double* s = work.kin.c + bodies_[description.body].i_c;
    NodeMotion motion = flexible.make_node_motion();
    flexible.node_motion(description.node, s, s + flexible.m(), nullptr, motion);
    const Vector3d from_node = motion.X_BN.R * description.X_BP.p;
    const Vector3d w_B = motion.V.angular, v_B = motion.V.linear + w_B.cross(from_node);
    MarkerState& marker = work.kin.markers[i];
    marker.X_WP = body.X_WB * (motion.X_BN * description.X_BP);
    const Vector3d r = marker.X_WP.p - body.X_WB.p;
    marker.V.angular = body.V.angular + body.X_WB.R * w_B;
    marker.V.linear = body.V.linear + body.V.angular.cross(r) + body.X_WB.R * v_B;
  }
}

}  // namespace flexura::mbs
