// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/motion/tree_motion.hpp"

#include <algorithm>
#include <limits>

namespace flexura::mbs {

void TreeMotion::size(Motion& motion) const {
  const MechanismDescription& d = tree_.d;
  motion.bodies.resize(d.bodies.size());
  motion.local.resize(d.markers.size());
  motion.kin.markers.resize(d.markers.size());
  motion.kin.joints = &tree_.places;
  motion.kin.bodies.resize(d.bodies.size());
  for (std::size_t b = 0; b < d.bodies.size(); ++b) motion.kin.bodies[b].loads = &d.bodies[b].loads;
  for (int b : tree_.order) motion.bodies[b].S.setZero(6, tree_.places[tree_.bodies[b].joint].joint->n_v());
  for (std::size_t i = 0; i < d.markers.size(); ++i) {
    const MarkerDescription& marker = d.markers[i];
    motion.local[i].X_BP = marker.X_BP;
    if (tree_.on_node[i]) motion.local[i].node = tree_.flexible(marker.body)->make_node_motion();
    // Where the deformation does not act back the marker stays, and loads see the undeformed body.
    if (tree_.on_node[i] && !tree_.is_carried[i])
      place_on_node(static_cast<int>(i),
                    Eigen::VectorXd(Eigen::VectorXd::Zero(tree_.flexible(marker.body)->m())).data(), nullptr,
                    nullptr, motion);
    if (marker.body == 0) motion.kin.markers[i].X_WP = marker.X_BP;
  }
}

void TreeMotion::forward(Level level, double t, const double* p, const double* v, const double* v_dot,
                         Motion& motion) const {
  motion.kin.t = t;
  motion.kin.p = p;
  motion.kin.v = v;
  motion.kin.v_dot = v_dot;
  for (int b : tree_.order) {
    const TreeBody& body = tree_.bodies[b];
    if (body.m > 0) {
      motion.kin.bodies[b].s = p + body.i_p;
      motion.kin.bodies[b].s_dot = v ? v + body.i_v : nullptr;
    }
    for (int i : tree_.markers_of_body[b])
      if (tree_.is_carried[i])
        place_on_node(i, p + body.i_p, level == Level::position ? nullptr : v + body.i_v,
                      level == Level::acceleration ? v_dot + body.i_v : nullptr, motion);
    move_through_joint(b, level, motion);
    place_markers(b, level, motion);
  }
}

void TreeMotion::place_on_node(int marker, const double* s, const double* s_dot, const double* s_ddot,
                               Motion& motion) const {
  const MarkerDescription& description = tree_.d.markers[marker];
  Motion::LocalMarker& local = motion.local[marker];
  NodeMotion& node = local.node;
  tree_.d.bodies[description.body].flexible->node_motion(description.node, s, s_dot, s_ddot, node);
  // The marker stands r from the node: v += w x r, a += alpha x r + w x (w x r).
  const Vector3d r = node.X_BN.R * description.X_BP.p;
  local.X_BP = {node.X_BN.R * description.X_BP.R, node.X_BN.p + r};
  if (r.isZero(0.0)) return;
  node.map.bottomRows<3>().noalias() -= skew(r) * node.map.topRows<3>();
  if (!s_dot) return;
  const Vector3d w_x_r = node.V.angular.cross(r);
  node.V.linear += w_x_r;
  if (s_ddot) node.A.linear += node.A.angular.cross(r) + node.V.angular.cross(w_x_r);
}

void TreeMotion::move_through_joint(int b, Level level, Motion& motion) const {
  const TreeBody& body = tree_.bodies[b];
  const JointPlace& place = tree_.places[body.joint];
  const Joint& joint = *place.joint;
  Motion::Body& out = motion.bodies[b];
  const MarkerState& in = motion.kin.markers[body.marker_in];
  const Motion::LocalMarker& local = motion.local[body.marker_out];
  const bool deforms = tree_.is_carried[body.marker_out];

  const double* q = motion.kin.p + place.i_p;
  out.X_in_out = joint.pose(q);
  joint.motion(q, out.S);
  const Pose X_FM = out.X_in_out;
  if (body.reversed) {
    // F moves relative to M: w_MF_M = -R_MF w_FM_F,  d/dt p_MoFo_M = R_MF (w x p - p'), p = p_FoMo_F.
    out.X_in_out = X_FM.inverse();
    for (int i = 0; i < out.S.cols(); ++i) {
      const Vector3d w = out.S.col(i).head<3>(), u = out.S.col(i).tail<3>();
      out.S.col(i).head<3>() = -(out.X_in_out.R * w);
      out.S.col(i).tail<3>() = out.X_in_out.R * (w.cross(X_FM.p) - u);
    }
  }
  const Pose X_W_out = in.X_WP * out.X_in_out;
  out.X_WB = X_W_out * local.X_BP.inverse();
  if (level == Level::position) return;

  // Twist of the outer marker's frame, then of the body: what the marker moves relative to the body comes
  // off.
  const double* v = motion.kin.v + place.i_v;
  Vector6d V_rel = Vector6d::Zero();
  for (int i = 0; i < out.S.cols(); ++i) V_rel += out.S.col(i) * v[i];
  const Spatial rel = in.X_WP.R * Spatial::from(V_rel);
  const Vector3d r = X_W_out.p - in.X_WP.p;
  const Vector3d& w_in = in.V.angular;
  const Spatial V_out{w_in + rel.angular, in.V.linear + w_in.cross(r) + rel.linear};
  const Vector3d to_body = out.X_WB.p - X_W_out.p;
  Spatial own;  // of the outer marker in its body
  if (deforms) own = out.X_WB.R * local.node.V;
  out.V.angular = V_out.angular - own.angular;
  out.V.linear = V_out.linear - own.linear + out.V.angular.cross(to_body);
  if (level == Level::velocity) return;

  out.bias = joint.bias(q, v);
  if (body.reversed) {
    // The derivative of the two lines above at v' = 0.
    Vector6d V_FM = Vector6d::Zero();
    MotionMatrix S(6, joint.n_v());
    joint.motion(q, S);
    for (int i = 0; i < S.cols(); ++i) V_FM += S.col(i) * v[i];
    const Vector3d w = V_FM.head<3>(), u = V_FM.tail<3>(), b_w = out.bias.head<3>(), b_u = out.bias.tail<3>();
    out.bias.head<3>() = -(out.X_in_out.R * b_w);
    out.bias.tail<3>() =
        out.X_in_out.R * (2.0 * w.cross(u) - w.cross(w.cross(X_FM.p)) - b_u + b_w.cross(X_FM.p));
  }
  const double* v_dot = motion.kin.v_dot + place.i_v;
  Vector6d A_rel = out.bias;
  for (int i = 0; i < out.S.cols(); ++i) A_rel += out.S.col(i) * v_dot[i];
  const Spatial rel_dot = in.X_WP.R * Spatial::from(A_rel);
  const Spatial A_out{in.A.angular + w_in.cross(rel.angular) + rel_dot.angular,
                      in.A.linear + in.A.angular.cross(r) + w_in.cross(w_in.cross(r)) +
                          2.0 * w_in.cross(rel.linear) + rel_dot.linear};
  const Vector3d& w = out.V.angular;
  out.A = A_out;
  if (deforms) {
    const Spatial own_dot = out.X_WB.R * local.node.A;
    out.A.angular -= w.cross(own.angular) + own_dot.angular;
    out.A.linear -= 2.0 * w.cross(own.linear) + own_dot.linear;
  }
  out.A.linear += out.A.angular.cross(to_body) + w.cross(w.cross(to_body));
}

void TreeMotion::place_markers(int b, Level level, Motion& motion) const {
  const Motion::Body& body = motion.bodies[b];
  const Vector3d& w = body.V.angular;
  for (int i : tree_.markers_of_body[b]) {
    const Motion::LocalMarker& local = motion.local[i];
    MarkerState& marker = motion.kin.markers[i];
    marker.X_WP = body.X_WB * local.X_BP;
    if (level == Level::position) continue;
    const Vector3d r = marker.X_WP.p - body.X_WB.p;
    marker.V = {w, body.V.linear + w.cross(r)};
    if (level == Level::acceleration)
      marker.A = {body.A.angular, body.A.linear + body.A.angular.cross(r) + w.cross(w.cross(r))};
    if (!tree_.is_carried[i]) continue;
    const Spatial rel = body.X_WB.R * local.node.V;
    marker.V += rel;
    if (level == Level::acceleration) {
      const Spatial rel_dot = body.X_WB.R * local.node.A;
      marker.A.angular += w.cross(rel.angular) + rel_dot.angular;
      marker.A.linear += 2.0 * w.cross(rel.linear) + rel_dot.linear;
    }
  }
}

void TreeMotion::show_following(Motion& motion) const {
  for (std::size_t i = 0; i < tree_.d.markers.size(); ++i) {
    if (!tree_.on_node[i] || tree_.is_carried[i]) continue;
    const MarkerDescription& description = tree_.d.markers[i];
    const Motion::Body& body = motion.bodies[description.body];
    const FlexibleBody& flexible = *tree_.d.bodies[description.body].flexible;
    const double* s = motion.kin.c + tree_.bodies[description.body].i_c;
    NodeMotion node = flexible.make_node_motion();
    flexible.node_motion(description.node, s, s + flexible.m(), nullptr, node);
    const Vector3d from_node = node.X_BN.R * description.X_BP.p;
    const Vector3d w_B = node.V.angular, v_B = node.V.linear + w_B.cross(from_node);
    MarkerState& marker = motion.kin.markers[i];
    marker.X_WP = body.X_WB * (node.X_BN * description.X_BP);
    const Vector3d r = marker.X_WP.p - body.X_WB.p;
    marker.V.angular = body.V.angular + body.X_WB.R * w_B;
    marker.V.linear = body.V.linear + body.V.angular.cross(r) + body.X_WB.R * v_B;
  }
}

double TreeMotion::extent(const Motion& motion) const {
  const double none = std::numeric_limits<double>::infinity();
  Vector3d low = Vector3d::Constant(none), high = -low;
  const auto take = [&](const Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  for (std::size_t i = 0; i < tree_.d.markers.size(); ++i) take(motion.kin.markers[i].X_WP.p);
  for (const int b : tree_.order)
    if (const RigidInertia& I = tree_.d.bodies[b].inertia; I.mass > 0.0)
      take(motion.bodies[b].X_WB * Vector3d(I.mass_center / I.mass));
  return tree_.d.markers.empty() ? 1e-6 : std::max(1e-6, (high - low).norm());
}

}  // namespace flexura::mbs
