// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/tangents/inertia_tangents.hpp"

#include <algorithm>

#include "mbs/mechanism/tangents/variation.hpp"

/// Derivatives of the inverse dynamics in closed form, after J. Carpentier, N. Mansard, Analytical
/// Derivatives of Rigid Body Dynamics Algorithms, RSS 2018, and S. Singh, R. P. Russo, P. M. Wensing, IEEE
/// Robotics and Automation Letters 7 (2022) 1776-1783, here for joints with any columns, quasi-velocities and
/// modal coordinates.
///
/// All twists V, accelerations A = dV/dt and wrenches F are taken about one point at rest (the origin that
/// the branch's first body has at this instant).  A coordinate j moves all that is outboard of it like one
/// rigid body, along phi.  With x and x* the cross products of motions and of wrenches,
///
///     dX = phi,     dV = phi x V + D,     dA = phi x A + D x V + E                                (1)
///
/// where D and E are the same for all of it: the motion of bodies relative to the first that moves turns with
/// it.  They follow from the joint's own motion, dV and dA of its outer frame M with the inner frame F held:
/// D = dV - phi x V, E = dA - phi x A - D x V.  A speed moves nothing, phi = 0 and D = its column; v_dot only
/// E.  A joint that the tree passes from M to F has the negative of all three.  Gravity g is an acceleration
/// -g that does not turn: E + phi x g stands for E.
///
/// A body needs F(A, V) = I A + (terms of w), and seen from the body that moves along, by (1),
///
///     dF = phi x* F + I E + B D_w,     B D_w = I (D_w x w, 2 D_w x v) + F_w D_w                   (2)
///
/// (about its own origin D's linear part cancels), so that sums over all bodies outboard (F, I, B: 6 x 6 and
/// 6 x 3) say how their wrench changes.  The force along coordinate i is phi_i . F.  Where j lies inboard of
/// i the turning of phi_i and of F cancel:
///
///     j inboard of i     dr_i = (I phi_i) . E_j + (B^T phi_i) . D_w,j
///     j outboard of i    dr_i = phi_i . (phi_j x* F + I E_j + B D_w,j)
///     in one joint       dr_i = the same + (d phi_i / dq_j) . F
///
/// A modal coordinate's row is that of its body's modal force, C^T A + (terms of w), and of the markers on
/// nodes, which it moves along eta: + eta . F of what hangs there, - eta . F of the body at its outer marker.
namespace flexura::mbs {

using Eigen::MatrixXd;

void InertiaTangents::size(InertiaVariations& T) const {
  T.bodies.resize(tree_.d.bodies.size());
  T.deformations.resize(tree_.d.bodies.size());
  T.markers.resize(tree_.d.markers.size());
  int widest = 0;
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    T.bodies[b].modal_w.setZero(t.m, 3);
    T.bodies[b].depth = T.bodies[t.parent].depth + 1;
    if (const FlexibleBody* flexible = tree_.flexible(b))
      T.deformations[b] = flexible->make_deformation_tangents();
    if (t.m == 0) continue;
    widest = std::max(widest, t.m);
    for (const int i : tree_.markers_of_body[b])
      if (tree_.is_carried[i])
        for (InertiaVariations::Columns6* x :
             {&T.markers[i].eta, &T.markers[i].D, &T.markers[i].E, &T.markers[i].E_v})
          x->setZero(6, t.m);
  }
  T.G_p.setZero(6, widest);
  T.G_v.setZero(6, widest);
  for (InertiaVariations::Columns6* m : {&T.phi, &T.D, &T.E, &T.E_v, &T.row_E, &T.H_p, &T.H_v})
    m->setZero(6, tree_.n_v);
  T.row_w.setZero(3, tree_.n_v);
}

void InertiaTangents::vary_joints(const Motion& motion, InertiaVariations& variations) const {
  InertiaVariations& T = variations;
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    const JointPlace& place = tree_.places[t.joint];
    const Joint& joint = *place.joint;
    InertiaVariations::BranchOfBody& branch = T.bodies[b];
    branch.origin = t.parent == 0 ? motion.bodies[b].X_WB.p : T.bodies[t.parent].origin;

    const int n = joint.n_v();
    const double *q = motion.kin.p + place.i_p, *v = motion.kin.v + place.i_v,
                 *v_dot = motion.kin.v_dot + place.i_v;
    const MarkerState &F = motion.kin.markers[place.marker_F], &M = motion.kin.markers[place.marker_M];
    const Matrix3d& R = F.X_WP.R;
    MotionMatrix S = MotionMatrix::Zero(6, n);
    joint.motion(q, S);
    MotionDerivatives& d = T.joint;
    const bool constant = joint.has_constant_motion();
    if (!constant) joint.motion_derivatives(q, v, d);
    const double sign = t.reversed ? -1.0 : 1.0;
    for (int j = 0; j < n; ++j) {
      const Vector3d w_j = R * S.col(j).head<3>(), u_j = R * S.col(j).tail<3>();
      Spatial V_q, A_q, A_v;  // S v by q, S v' + bias by q and bias by v, in W
      if (!constant) {
        Vector6d by_v = Vector6d::Zero(), by_a = d.bias_q.col(j);
        for (int i = 0; i < n; ++i) {
          by_v += v[i] * d.S_q[j].col(i);
          by_a += v_dot[i] * d.S_q[j].col(i);
        }
        V_q = R * Spatial::from(by_v);
        A_q = R * Spatial::from(by_a);
        A_v = R * Spatial::from(d.bias_v.col(j));
      }
      const RelativeChange d_M(F.V, F.A, w_j, u_j, V_q, A_q, A_v);
      const Variation x = variation(M, branch.origin, d_M.by_q), y = variation(M, branch.origin, d_M.by_v);
      const int k = place.i_v + j;
      T.phi.col(k) = sign * x.phi.vector();
      T.D.col(k) = sign * x.D.vector();
      T.E.col(k) = sign * x.E.vector();
      T.E_v.col(k) = sign * y.E.vector();
      T.E.col(k).tail<3>() += sign * x.phi.angular.cross(tree_.d.gravity);
    }
    // d phi_i / dq_j: M moves by S_j; what is inboard of a reversed joint is M, which then stays.
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const Vector3d w_i = R * S.col(i).head<3>(), dp = R * S.col(j).tail<3>();
        Spatial own;
        if (!constant) own = R * Spatial::from(d.S_q[j].col(i));
        own.linear -= own.angular.cross(M.X_WP.p - branch.origin) + w_i.cross(dp);
        if (t.reversed)
          own =
              cross_motion(Spatial::from(T.phi.col(place.i_v + j)), Spatial::from(T.phi.col(place.i_v + i))) -
              own;
        branch.own_turns[j][i] = own;
      }
  }
}

void InertiaTangents::vary_inertia(const Motion& motion, Wrenches& wrenches, const Inertias& inertias,
                                   InertiaVariations& variations) const {
  InertiaVariations& T = variations;
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    const Motion::Body& body = motion.bodies[b];
    const Inertias::Body& inertia = inertias.bodies[b];
    InertiaVariations::BranchOfBody& branch = T.bodies[b];
    const Matrix3d& R = body.X_WB.R;
    const Vector3d &w = body.V.angular, &v = body.V.linear;
    const Vector3d to_body = body.X_WB.p - branch.origin;
    const Matrix6d X = transport_twist(to_body);
    branch.F = shift_wrench(wrenches.bodies[b].F, to_body);

    Eigen::Matrix<double, 6, 3> F_w, turn;
    if (t.m > 0) {
      tree_.d.bodies[b].flexible->turning_tangents(motion.kin.p + t.i_p, motion.kin.v + t.i_v,
                                                   R.transpose() * w, *wrenches.bodies[b].flexible, F_w,
                                                   branch.modal_w);
      F_w.topRows<3>() = (R * F_w.topRows<3>() * R.transpose()).eval();
      F_w.bottomRows<3>() = (R * F_w.bottomRows<3>() * R.transpose()).eval();
    } else {
      const Matrix3d J = inertia.I_c.topLeftCorner<3, 3>();
      const Vector3d d = R * tree_.d.bodies[b].inertia.mass_center;
      F_w.topRows<3>() = skew(w) * J - skew(J * w);
      F_w.bottomRows<3>() = -skew(w.cross(d)) - skew(w) * skew(d);
    }
    turn << -skew(w), -2.0 * skew(v);
    branch.I = X.transpose() * inertia.I_c * X;
    branch.B = X.transpose() * (inertia.I_c * turn + F_w);

    if (t.m == 0) continue;
    for (const int i : tree_.markers_of_body[b])
      if (tree_.is_carried[i])
        for (int l = 0; l < t.m; ++l)
          T.markers[i].eta.col(l) = shift_twist(R * Spatial::from(motion.local[i].node.map.col(l)),
                                                branch.origin - motion.kin.markers[i].X_WP.p)
                                        .vector();
    for (int l = 0; l < t.m; ++l) {
      const Spatial C = Spatial::from(inertia.C_c.col(l));
      T.phi.col(t.i_v + l) =
          shift_twist(Spatial::from(inertias.K[b].col(inertias.K[b].cols() - t.m + l)), -to_body).vector();
      T.row_E.col(t.i_v + l) = shift_wrench(C, to_body).vector();
      T.row_w.col(t.i_v + l) =
          w.cross(C.angular) + 2.0 * v.cross(C.linear) + R * branch.modal_w.row(l).transpose();
    }
  }
  for (auto it = tree_.order.rbegin(); it != tree_.order.rend(); ++it) {
    const int b = *it;
    const TreeBody& t = tree_.bodies[b];
    InertiaVariations::BranchOfBody& branch = T.bodies[b];
    for (int i = tree_.places[t.joint].i_v; i < t.i_v; ++i) {
      T.row_E.col(i) = branch.I * T.phi.col(i);
      T.row_w.col(i) = branch.B.transpose() * T.phi.col(i);
      T.H_p.col(i) = branch.I * T.E.col(i) + branch.B * T.D.col(i).head<3>() +
                     cross_force(Spatial::from(T.phi.col(i)), branch.F).vector();
      T.H_v.col(i) = branch.I * T.E_v.col(i) + branch.B * T.phi.col(i).head<3>();
    }
    if (tree_.is_carried[t.marker_out])
      for (int l = t.i_v; l < t.i_v + t.m; ++l) {
        T.row_E.col(l) += branch.I * T.phi.col(l);
        T.row_w.col(l) += branch.B.transpose() * T.phi.col(l);
      }
    if (t.parent == 0) continue;
    InertiaVariations::BranchOfBody& parent = T.bodies[t.parent];
    parent.I += branch.I;
    parent.B += branch.B;
    if (!tree_.is_carried[t.marker_in]) continue;
    const TreeBody& tp = tree_.bodies[t.parent];
    const auto& eta = T.markers[t.marker_in].eta;
    for (int l = 0; l < tp.m; ++l) {
      T.row_E.col(tp.i_v + l) += branch.I * eta.col(l);
      T.row_w.col(tp.i_v + l) += branch.B.transpose() * eta.col(l);
    }
  }
}

void InertiaTangents::joint_columns(bool with_modes, const InertiaVariations& variations, MatrixXd& z_q,
                                    MatrixXd& z_v) const {
  const InertiaVariations& T = variations;
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    const InertiaVariations::BranchOfBody& branch = T.bodies[b];
    const int first = tree_.places[t.joint].i_v, end = t.i_v + t.m, end_columns = with_modes ? end : t.i_v;
    for (int j = first; j < t.i_v; ++j) {
      for (int i = first; i < t.i_v; ++i) {
        z_q(i, j) = T.phi.col(i).dot(T.H_p.col(j)) + branch.own_turns[j - first][i - first].dot(branch.F);
        z_v(i, j) = T.phi.col(i).dot(T.H_v.col(j));
      }
      for (int i = t.i_v; i < end; ++i) {
        z_q(i, j) = T.row_E.col(i).dot(T.E.col(j)) + T.row_w.col(i).dot(T.D.col(j).head<3>());
        z_v(i, j) = T.row_E.col(i).dot(T.E_v.col(j)) + T.row_w.col(i).dot(T.phi.col(j).head<3>());
      }
    }
    for (int j = t.i_v; j < end_columns; ++j)
      for (int i = first; i < t.i_v; ++i) {
        z_q(i, j) = T.phi.col(i).dot(T.H_p.col(j));
        z_v(i, j) = T.phi.col(i).dot(T.H_v.col(j));
      }
    for (int child = b; tree_.bodies[child].parent != 0; child = tree_.bodies[child].parent) {
      const TreeBody& ta = tree_.bodies[tree_.bodies[child].parent];
      const int marker = tree_.bodies[child].marker_in, first_a = tree_.places[ta.joint].i_v;
      const bool on_node = tree_.is_carried[marker];
      const InertiaVariations::MovedNode& node = T.markers[marker];
      for (int j = first_a; j < (with_modes ? ta.i_v + ta.m : ta.i_v); ++j) {
        Vector6d E = T.E.col(j), E_v = T.E_v.col(j);
        Vector3d D_w = T.D.col(j).head<3>(), phi_w = T.phi.col(j).head<3>();
        if (const int l = j - ta.i_v; on_node && l >= 0) {
          E += node.E.col(l);
          E_v += node.E_v.col(l);
          D_w += node.D.col(l).head<3>();
          phi_w += node.eta.col(l).head<3>();
        }
        for (int i = first; i < end; ++i) {
          z_q(i, j) = T.row_E.col(i).dot(E) + T.row_w.col(i).dot(D_w);
          z_v(i, j) = T.row_E.col(i).dot(E_v) + T.row_w.col(i).dot(phi_w);
        }
      }
      for (int j = first; j < end_columns; ++j) {
        for (int i = first_a; i < ta.i_v + ta.m; ++i) {
          z_q(i, j) = T.phi.col(i).dot(T.H_p.col(j));
          z_v(i, j) = T.phi.col(i).dot(T.H_v.col(j));
        }
        for (int l = 0; on_node && l < ta.m; ++l) {
          z_q(ta.i_v + l, j) += node.eta.col(l).dot(T.H_p.col(j));
          z_v(ta.i_v + l, j) += node.eta.col(l).dot(T.H_v.col(j));
        }
      }
    }
  }
}

}  // namespace flexura::mbs
