// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/LU>

#include "mbs/mechanism/joined.hpp"

/// Axes that turn: the same motion through a tree joint, its components in axes K that turn with Omega
/// relative to the joint's frame F and coincide with F's now.
///
///     V_FM = S v,     S exp(t W) = diag(R, R) S,  R = exp(t [Omega]x)     =>     S W = ad S
///
/// with ad = diag([Omega]x, [Omega]x).  W is there where the span of S is the same in all these axes: a ball
/// joint's and a free joint's, a plane's turning in itself, a hinge's turning about its pin (W = 0 then).
namespace flexura::mbs {
namespace {

void turn(const JointPlace& place, const double* q, const Vector3d& Omega_F, Eigen::MatrixXd& W) {
  const Joint& joint = *place.joint;
  if (joint.n_v() == 0 || !joint.has_constant_motion() || Omega_F.isZero(0.0)) return;
  MotionMatrix S(6, joint.n_v());
  joint.motion(q, S);
  const Matrix3d cross = skew(Omega_F);
  MotionMatrix turned(6, joint.n_v());
  turned.topRows<3>() = cross * S.topRows<3>();
  turned.bottomRows<3>() = cross * S.bottomRows<3>();
  const Eigen::MatrixXd gram = S.transpose() * S, own = gram.inverse() * (S.transpose() * turned);
  // What rounding leaves of a span that is kept.
  if ((S * own - turned).norm() > 1e-9 * Omega_F.norm()) return;
  W.block(place.i_v, place.i_v, joint.n_v(), joint.n_v()) = own;
}

}  // namespace

Eigen::MatrixXd Mechanism::turning_axes(const State& s, const Vector3d& Omega_W, Scratch& scratch) const {
  MechanismScratch& work = scratch_of(scratch);
  m_->residual.move(TreeMotion::Level::velocity, s, nullptr, work);
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(m_->tree.n_v, m_->tree.n_v);
  for (const JointPlace& place : m_->tree.places) {
    if (!place.in_tree()) continue;
    const MarkerState& F = work.motion.kin.markers[place.marker_F];
    turn(place, s.p.data() + place.i_p, F.X_WP.R.transpose() * (Omega_W - F.V.angular), W);
  }
  return W;
}

Eigen::MatrixXd Mechanism::turning_with_bodies(const State& s, Scratch& scratch) const {
  MechanismScratch& work = scratch_of(scratch);
  m_->residual.move(TreeMotion::Level::velocity, s, nullptr, work);
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(m_->tree.n_v, m_->tree.n_v);
  for (const JointPlace& place : m_->tree.places)
    if (place.in_tree())
      turn(place, s.p.data() + place.i_p,
           work.motion.kin.relative_motion(place.marker_F, place.marker_M).V.head<3>(), W);
  return W;
}

}  // namespace flexura::mbs
