// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/motion/turning_axes.hpp"

#include <Eigen/LU>

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

Eigen::MatrixXd turning_axes(const Topology& tree, const State& s, const Vector3d& Omega_W,
                             const Motion& motion) {
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(tree.n_v, tree.n_v);
  for (const JointPlace& place : tree.places) {
    if (!place.in_tree()) continue;
    const MarkerState& F = motion.kin.markers[place.marker_F];
    turn(place, s.p.data() + place.i_p, F.X_WP.R.transpose() * (Omega_W - F.V.angular), W);
  }
  return W;
}

Eigen::MatrixXd turning_with_bodies(const Topology& tree, const State& s, const Motion& motion) {
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(tree.n_v, tree.n_v);
  for (const JointPlace& place : tree.places)
    if (place.in_tree())
      turn(place, s.p.data() + place.i_p,
           motion.kin.relative_motion(place.marker_F, place.marker_M).V.head<3>(), W);
  return W;
}

}  // namespace flexura::mbs
