// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/work.hpp"

/// The mass matrix by composite bodies (Featherstone, ch. 6), extended to modal coordinates: the composite of
/// a body is all that hangs on it with joints and modes at rest; it answers a twist of the body and its own
/// modal velocities. Everything is expressed in W about the body's origin Bo.
namespace flexura::mbs {
// Every body by itself, and its twists for unit velocities of its own coordinates; after forward().
void Mechanism::own_inertia(Work& work) const {
  deform_inertia(work);
  for (int b : order_) {
    Work::Body& body = work.bodies[b];
    const Matrix3d& R = body.X_WB.R;
    Vector3d d;
    double mass;
    if (bodies_[b].m > 0) {
      const FlexibleBody& flexible = *d_.bodies[b].flexible;
      mass = flexible.mass();
      d = R * body.flexible->d;
      body.I_c.topLeftCorner<3, 3>() = R * body.flexible->J * R.transpose();
      body.C_c.topRows<3>().noalias() = R * body.flexible->C_r;
      body.C_c.bottomRows<3>().noalias() = R * body.flexible->C_t;
      body.M_c = flexible.M_e();
    } else {
      const RigidInertia& I = d_.bodies[b].inertia;
      mass = I.mass;
      d = R * I.mass_center;
      body.I_c.topLeftCorner<3, 3>() = R * I.inertia * R.transpose();
    }
    body.I_c.topRightCorner<3, 3>() = skew(d);
    body.I_c.bottomLeftCorner<3, 3>() = -skew(d);
    body.I_c.bottomRightCorner<3, 3>() = mass * Matrix3d::Identity();
  }

  // Twists of each body for unit velocities of its own coordinates.
  for (int b : order_) {
    const TreeBody& t = bodies_[b];
    const Work::Body& body = work.bodies[b];
    const int n_j = static_cast<int>(body.S.cols());
    auto& K = work.K[b];
    const Matrix3d& R_in = work.kin.markers[t.marker_in].X_WP.R;
    const Vector3d to_body = body.X_WB.p - work.kin.markers[t.marker_out].X_WP.p;
    for (int j = 0; j < n_j; ++j)
      K.col(j) = shift_twist(R_in * Spatial::from(body.S.col(j)), to_body).vector();
    if (!is_carried_[t.marker_out]) continue;  // the modal columns stay zero
    for (int j = 0; j < t.m; ++j) {
      const Spatial own = body.X_WB.R * Spatial::from(work.local[t.marker_out].motion.map.col(j));
      K.col(n_j + j) = -shift_twist(own, to_body).vector();
    }
  }
}

void Mechanism::mass_matrix(ConstVectorRef p, Scratch& scratch, MatrixRef M) const {
  Work& work = work_of(scratch);
  forward(Level::position, 0.0, p.data(), nullptr, nullptr, work);
  own_inertia(work);
  M.setZero();

  for (auto it = order_.rbegin(); it != order_.rend(); ++it) {
    const int b = *it;
    const TreeBody& t = bodies_[b];
    const Work::Body& body = work.bodies[b];
    const auto& K = work.K[b];
    const int n = static_cast<int>(K.cols());
    const int first = places_[t.joint].i_v;  // the joint's speeds, then the body's modes, stand together

    // The wrench they need, and the forces along the body's own coordinates.
    auto H = work.H.leftCols(n);
    H.noalias() = body.I_c * K;
    H.rightCols(t.m) += body.C_c;
    auto own = M.block(first, first, n, n);
    own.noalias() = K.transpose() * H;
    own.bottomRows(t.m).noalias() += body.C_c.transpose() * K;
    own.bottomRightCorner(t.m, t.m) += body.M_c;

    // Inwards: the same wrench meets the coordinates of every body on the way to ground.
    for (int child = b; bodies_[child].parent != 0; child = bodies_[child].parent) {
      const TreeBody& tc = bodies_[child];
      const TreeBody& ta = bodies_[tc.parent];
      const Work::Body& parent = work.bodies[tc.parent];
      const int first_a = places_[ta.joint].i_v, n_a = static_cast<int>(work.K[tc.parent].cols());
      const Vector3d& p_in = work.kin.markers[tc.marker_in].X_WP.p;
      const Vector3d to_marker = work.bodies[child].X_WB.p - p_in, to_origin = p_in - parent.X_WB.p;
      const bool deforms = is_carried_[tc.marker_in];
      for (int j = 0; j < n; ++j) {
        const Spatial at_marker = shift_wrench(Spatial::from(H.col(j)), to_marker);
        H.col(j) = shift_wrench(at_marker, to_origin).vector();
        auto column = M.col(first + j).segment(first_a, n_a);
        column.noalias() = work.K[tc.parent].transpose() * H.col(j);
        if (deforms)  // modal velocities of the parent move the marker
          column.tail(ta.m).noalias() += work.local[tc.marker_in].motion.map.transpose() *
                                         (parent.X_WB.R.transpose() * at_marker).vector();
      }
      M.block(first, first_a, n, n_a) = M.block(first_a, first, n_a, n).transpose();
    }

    // The composite joins its parent's.
    if (t.parent == 0) continue;
    Work::Body& parent = work.bodies[t.parent];
    const Vector3d& p_in = work.kin.markers[t.marker_in].X_WP.p;
    const Matrix6d X = transport_twist(body.X_WB.p - parent.X_WB.p);
    parent.I_c += X.transpose() * body.I_c * X;
    if (is_carried_[t.marker_in]) {
      Eigen::Matrix<double, 6, Eigen::Dynamic> N = work.local[t.marker_in].motion.map;
      N.topRows<3>() = parent.X_WB.R * N.topRows<3>();
      N.bottomRows<3>() = parent.X_WB.R * N.bottomRows<3>();
      N = transport_twist(body.X_WB.p - p_in) * N;
      parent.C_c += X.transpose() * body.I_c * N;
      parent.M_c += N.transpose() * body.I_c * N;
    }
  }
}

}  // namespace flexura::mbs
