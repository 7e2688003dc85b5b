// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/tangents/mode_tangents.hpp"

#include "mbs/mechanism/tangents/variation.hpp"

/// Derivatives by a body's own elastic coordinates s, in the terms of inertia_tangents.cpp.
///
/// s_l moves the body with all that hangs on it by the negative of what it moves the outer marker in the body
/// (the joint's frame stays), and beyond that each node by (eta, D, E) with what hangs there.  It changes the
/// body's own wrench by need_s, so that beside the rigid part, (2) with phi_l, D_l, E_l,
///
///     G_l = need_s,l + sum over children c on nodes of X_c,l,     X_c,l = eta_l x* F_c + I_c E_l + B_c D_w,l
///
/// and the modal force k of the body itself by
///
///     (row k as for any inboard coordinate)
///         + phi_k . G_l + sum_c eta_k . X_c,l + modal_s + (d map_k / ds_l) . f
///
/// with f all that acts on each node: what hangs there needs F_c, at the outer marker -F, less the loads.
namespace flexura::mbs {

using Eigen::MatrixXd;

// (eta, D, E) of the nodes, and what the turning of their maps adds to the body's own block.
void ModeTangents::vary_nodes(int b, const Motion& motion, const Wrenches& wrenches,
                              InertiaVariations& variations, MatrixXd& z_q) const {
  InertiaVariations& T = variations;
  const TreeBody& t = tree_.bodies[b];
  const Motion::Body& body = motion.bodies[b];
  const Matrix3d& R = body.X_WB.R;
  const Vector3d& origin = T.bodies[b].origin;
  DeformationTangents& d = T.deformations[b];
  for (const int i : tree_.markers_of_body[b]) {
    if (!tree_.is_carried[i]) continue;
    const Motion::LocalMarker& local = motion.local[i];
    // The node's own frame, a rigid piece with the marker's.
    const Vector3d to_node = R * (local.node.X_BN.p - local.X_BP.p);
    MarkerState N = motion.kin.markers[i];
    N.X_WP.p += to_node;
    N.V = shift_twist(N.V, to_node);
    N.A = shift_twist(N.A, to_node);
    N.A.linear += N.V.angular.cross(N.V.angular.cross(to_node));

    Spatial f = shift_wrench(-wrenches.on_marker[i], -to_node);
    const auto add = [&](const Spatial& F, double sign) {
      const Spatial at_node = shift_wrench(F, origin - N.X_WP.p);
      f.angular += sign * at_node.angular;
      f.linear += sign * at_node.linear;
    };
    if (t.marker_out == i) add(T.bodies[b].F, -1.0);
    for (const int c : tree_.order)
      if (tree_.bodies[c].marker_in == i) add(T.bodies[c].F, 1.0);
    tree_.d.bodies[b].flexible->node_tangents(tree_.d.markers[i].node, motion.kin.p + t.i_p,
                                              motion.kin.v + t.i_v, motion.kin.v_dot + t.i_v,
                                              (R.transpose() * f).vector(), d);
    z_q.block(t.i_v, t.i_v, t.m, t.m) += d.map_s;

    InertiaVariations::MovedNode& moved = T.markers[i];
    for (int l = 0; l < t.m; ++l) {
      const Spatial column = shift_twist(R * Spatial::from(local.node.map.col(l)), to_node);
      const Vector3d &w = column.angular, &u = column.linear;
      // f stays in its place in the body while its map's origin, the node, moves by u.
      const Vector3d u_x_f = R.transpose() * u.cross(f.linear);
      z_q.col(t.i_v + l).segment(t.i_v, t.m).noalias() -= local.node.map.topRows<3>().transpose() * u_x_f;
      const Spatial V_s = R * Spatial::from(d.motion_s.col(l)),
                    A_s = R * Spatial::from(d.acceleration_s.col(l)),
                    A_v = R * Spatial::from(d.acceleration_v.col(l));
      const RelativeChange d_N(body.V, body.A, w, u, V_s, A_s, A_v);
      const Variation x = variation(N, origin, d_N.by_q), y = variation(N, origin, d_N.by_v);
      moved.D.col(l) = x.D.vector();
      moved.E.col(l) = x.E.vector();
      moved.E.col(l).tail<3>() += x.phi.angular.cross(tree_.d.gravity);
      moved.E_v.col(l) = y.E.vector();
    }
  }
}

void ModeTangents::mode_columns(const Motion& motion, Wrenches& wrenches, InertiaVariations& variations,
                                MatrixXd& z_q, MatrixXd& z_v) const {
  InertiaVariations& T = variations;
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    if (t.m == 0) continue;
    const int m = t.m, first = t.i_v;
    const Motion::Body& body = motion.bodies[b];
    const InertiaVariations::BranchOfBody& branch = T.bodies[b];
    const Matrix3d& R = body.X_WB.R;
    DeformationTangents& d = T.deformations[b];
    const Spatial V = R.transpose() * body.V;
    const Spatial A = R.transpose() * Spatial{body.A.angular, body.A.linear - tree_.d.gravity};
    tree_.d.bodies[b].flexible->deformation_tangents(motion.kin.p + t.i_p, motion.kin.v + t.i_v,
                                                     motion.kin.v_dot + t.i_v, V, A,
                                                     *wrenches.bodies[b].flexible, d);
    z_q.block(first, first, m, m) = d.modal_s;
    z_v.block(first, first, m, m) = d.modal_v;
    vary_nodes(b, motion, wrenches, variations, z_q);

    const Vector3d to_body = body.X_WB.p - branch.origin;
    for (int l = 0; l < m; ++l) {
      T.G_p.col(l) = shift_wrench(R * Spatial::from(d.need_s.col(l)), to_body).vector();
      T.G_v.col(l) = shift_wrench(R * Spatial::from(d.need_v.col(l)), to_body).vector();
      if (!tree_.is_carried[t.marker_out]) continue;
      const InertiaVariations::MovedNode& out = T.markers[t.marker_out];
      T.D.col(first + l) = -out.D.col(l);
      T.E.col(first + l) = -out.E.col(l);
      T.E_v.col(first + l) = -out.E_v.col(l);
    }
    for (const int c : tree_.order) {
      if (tree_.bodies[c].parent != b || !tree_.is_carried[tree_.bodies[c].marker_in]) continue;
      const InertiaVariations::MovedNode& node = T.markers[tree_.bodies[c].marker_in];
      const InertiaVariations::BranchOfBody& outboard = T.bodies[c];
      for (int l = 0; l < m; ++l) {
        const Vector6d X_p = cross_force(Spatial::from(node.eta.col(l)), outboard.F).vector() +
                             outboard.I * node.E.col(l) + outboard.B * node.D.col(l).head<3>();
        const Vector6d X_v = outboard.I * node.E_v.col(l) + outboard.B * node.eta.col(l).head<3>();
        T.G_p.col(l) += X_p;
        T.G_v.col(l) += X_v;
        for (int k = 0; k < m; ++k) {
          z_q(first + k, first + l) += node.eta.col(k).dot(X_p);
          z_v(first + k, first + l) += node.eta.col(k).dot(X_v);
        }
      }
    }
    for (int j = first; j < first + m; ++j) {
      const auto G_p = T.G_p.col(j - first), G_v = T.G_v.col(j - first);
      const Vector6d phi = T.phi.col(j), D = T.D.col(j), E = T.E.col(j), E_v = T.E_v.col(j);
      T.H_p.col(j) =
          cross_force(Spatial::from(phi), branch.F).vector() + branch.I * E + branch.B * D.head<3>() + G_p;
      T.H_v.col(j) = branch.I * E_v + branch.B * phi.head<3>() + G_v;
      for (int i = first; i < first + m; ++i) {
        z_q(i, j) += T.row_E.col(i).dot(E) + T.row_w.col(i).dot(D.head<3>()) + T.phi.col(i).dot(G_p);
        z_v(i, j) += T.row_E.col(i).dot(E_v) + T.row_w.col(i).dot(phi.head<3>()) + T.phi.col(i).dot(G_v);
      }
    }
  }
}

void ModeTangents::following_columns(const Motion& motion, Wrenches& wrenches, InertiaVariations& variations,
                                     MatrixXd& z_c) const {
  for (int b : tree_.order) {
    if (tree_.bodies[b].i_c < 0) continue;
    const int m = tree_.bodies[b].n_need, i = tree_.bodies[b].i_c;
    const Motion::Body& body = motion.bodies[b];
    DeformationTangents& d = variations.deformations[b];
    const Matrix3d& R = body.X_WB.R;
    const double* s = motion.kin.c + i;
    tree_.d.bodies[b].flexible->deformation_tangents(
        s, s + m, wrenches.bodies[b].no_acceleration.data(), R.transpose() * body.V,
        R.transpose() * Spatial{body.A.angular, body.A.linear - tree_.d.gravity},
        *wrenches.bodies[b].flexible, d);
    z_c.block(tree_.n_v + i, i + m, m, m).setIdentity();
    z_c.block(tree_.n_v + i + m, i, m, m) = -d.modal_s;
    z_c.block(tree_.n_v + i + m, i + m, m, m) = -d.modal_v;
  }
}

}  // namespace flexura::mbs
