// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/dynamics/mass_matrix.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

/// The mass matrix by composite bodies (Featherstone, ch. 6), extended to modal coordinates: the composite of
/// a body is all that hangs on it with joints and modes at rest; it answers a twist of the body and its own
/// modal velocities. Everything is expressed in W about the body's origin Bo.
namespace flexura::mbs {

void MassMatrix::size(Inertias& inertias) const {
  const std::size_t n = tree_.d.bodies.size();
  inertias.bodies.resize(n);
  inertias.K.resize(n);
  inertias.articulated.resize(n);
  int widest = 0;
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    const int n_b = tree_.places[t.joint].joint->n_v() + t.m;
    inertias.bodies[b].C_c.setZero(6, t.m);
    inertias.bodies[b].M_c.setZero(t.m, t.m);
    inertias.K[b].setZero(6, n_b);
    widest = std::max(widest, n_b);
    Inertias::Articulated& a = inertias.articulated[b];
    a.K.setZero(6, n_b);
    a.U.setZero(6, n_b);
    a.L.setZero(n_b, n_b);
    a.N.setZero(6, tree_.bodies[t.parent].m);
    a.q.setZero(t.m);
  }
  inertias.H.setZero(6, widest);
}

void MassMatrix::own_inertia(const Motion& motion, const Wrenches& wrenches, Inertias& inertias) const {
  for (int b : tree_.order) {
    const Motion::Body& moves = motion.bodies[b];
    Inertias::Body& body = inertias.bodies[b];
    const Matrix3d& R = moves.X_WB.R;
    Vector3d d;
    double mass;
    if (tree_.bodies[b].m > 0) {
      const FlexibleBody& flexible = *tree_.d.bodies[b].flexible;
      mass = flexible.mass();
      d = R * wrenches.bodies[b].flexible->d;
      body.I_c.topLeftCorner<3, 3>() = R * wrenches.bodies[b].flexible->J * R.transpose();
      body.C_c.topRows<3>().noalias() = R * wrenches.bodies[b].flexible->C_r;
      body.C_c.bottomRows<3>().noalias() = R * wrenches.bodies[b].flexible->C_t;
      body.M_c = flexible.M_e(*wrenches.bodies[b].flexible);
    } else {
      const RigidInertia& I = tree_.d.bodies[b].inertia;
      mass = I.mass;
      d = R * I.mass_center;
      body.I_c.topLeftCorner<3, 3>() = R * I.inertia * R.transpose();
    }
    body.I_c.topRightCorner<3, 3>() = skew(d);
    body.I_c.bottomLeftCorner<3, 3>() = -skew(d);
    body.I_c.bottomRightCorner<3, 3>() = mass * Matrix3d::Identity();
  }

  // Twists of each body for unit velocities of its own coordinates.
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    const Motion::Body& moves = motion.bodies[b];
    const int n_j = static_cast<int>(moves.S.cols());
    auto& K = inertias.K[b];
    const Matrix3d& R_in = motion.kin.markers[t.marker_in].X_WP.R;
    const Vector3d to_body = moves.X_WB.p - motion.kin.markers[t.marker_out].X_WP.p;
    for (int j = 0; j < n_j; ++j)
      K.col(j) = shift_twist(R_in * Spatial::from(moves.S.col(j)), to_body).vector();
    if (!tree_.is_carried[t.marker_out]) continue;  // the modal columns stay zero
    for (int j = 0; j < t.m; ++j) {
      const Spatial own = moves.X_WB.R * Spatial::from(motion.local[t.marker_out].node.map.col(j));
      K.col(n_j + j) = -shift_twist(own, to_body).vector();
    }
  }
}

void MassMatrix::fill(const Motion& motion, Inertias& inertias, MatrixRef M) const {
  M.setZero();

  for (auto it = tree_.order.rbegin(); it != tree_.order.rend(); ++it) {
    const int b = *it;
    const TreeBody& t = tree_.bodies[b];
    const Motion::Body& moves = motion.bodies[b];
    const Inertias::Body& body = inertias.bodies[b];
    const auto& K = inertias.K[b];
    const int n = static_cast<int>(K.cols());
    const int first = tree_.places[t.joint].i_v;  // the joint's speeds, then the body's modes, stand together

    // The wrench they need, and the forces along the body's own coordinates.
    auto H = inertias.H.leftCols(n);
    H.noalias() = body.I_c * K;
    H.rightCols(t.m) += body.C_c;
    auto own = M.block(first, first, n, n);
    own.noalias() = K.transpose() * H;
    own.bottomRows(t.m).noalias() += body.C_c.transpose() * K;
    own.bottomRightCorner(t.m, t.m) += body.M_c;

    // Inwards: the same wrench meets the coordinates of every body on the way to ground.
    for (int child = b; tree_.bodies[child].parent != 0; child = tree_.bodies[child].parent) {
      const TreeBody& tc = tree_.bodies[child];
      const TreeBody& ta = tree_.bodies[tc.parent];
      const Motion::Body& parent = motion.bodies[tc.parent];
      const int first_a = tree_.places[ta.joint].i_v, n_a = static_cast<int>(inertias.K[tc.parent].cols());
      const Vector3d& p_in = motion.kin.markers[tc.marker_in].X_WP.p;
      const Vector3d to_marker = motion.bodies[child].X_WB.p - p_in, to_origin = p_in - parent.X_WB.p;
      const bool deforms = tree_.is_carried[tc.marker_in];
      for (int j = 0; j < n; ++j) {
        const Spatial at_marker = shift_wrench(Spatial::from(H.col(j)), to_marker);
        H.col(j) = shift_wrench(at_marker, to_origin).vector();
        auto column = M.col(first + j).segment(first_a, n_a);
        column.noalias() = inertias.K[tc.parent].transpose() * H.col(j);
        if (deforms)  // modal velocities of the parent move the marker
          column.tail(ta.m).noalias() += motion.local[tc.marker_in].node.map.transpose() *
                                         (parent.X_WB.R.transpose() * at_marker).vector();
      }
      M.block(first, first_a, n, n_a) = M.block(first_a, first, n_a, n).transpose();
    }

    // The composite joins its parent's.
    if (t.parent == 0) continue;
    const Pose& X_W_parent = motion.bodies[t.parent].X_WB;
    Inertias::Body& parent = inertias.bodies[t.parent];
    const Vector3d& p_in = motion.kin.markers[t.marker_in].X_WP.p;
    const Matrix6d X = transport_twist(moves.X_WB.p - X_W_parent.p);
    parent.I_c += X.transpose() * body.I_c * X;
    if (tree_.is_carried[t.marker_in]) {
      Eigen::Matrix<double, 6, Eigen::Dynamic> N = motion.local[t.marker_in].node.map;
      N.topRows<3>() = X_W_parent.R * N.topRows<3>();
      N.bottomRows<3>() = X_W_parent.R * N.bottomRows<3>();
      N = transport_twist(moves.X_WB.p - p_in) * N;
      parent.C_c += X.transpose() * body.I_c * N;
      parent.M_c += N.transpose() * body.I_c * N;
    }
  }
}

void MassMatrix::check(MatrixRef M, const Coordinates& coordinates) const {
  // Cholesky's method; a pivot at round-off of its diagonal entry means no inertia beside the coordinates
  // before it.
  for (int i = 0; i < tree_.n_v; ++i) {
    const double diagonal = M(i, i);
    for (int k = 0; k < i; ++k) M(i, i) -= M(i, k) * M(i, k);
    if (!(M(i, i) > 1e-14 * diagonal)) {
      std::string body;
      for (int b : tree_.order)
        if (tree_.places[tree_.bodies[b].joint].i_v <= i) body = tree_.d.bodies[b].name;
      throw std::invalid_argument(
          fmt::format("nothing with inertia moves along \"{}\" alone; give body \"{}\", or what hangs on it, "
                      "mass or inertia",
                      coordinates.name_of_velocity(i), body));
    }
    M(i, i) = std::sqrt(M(i, i));
    for (int j = i + 1; j < tree_.n_v; ++j) {
      for (int k = 0; k < i; ++k) M(j, i) -= M(j, k) * M(i, k);
      M(j, i) /= M(i, i);
    }
  }
}

}  // namespace flexura::mbs
