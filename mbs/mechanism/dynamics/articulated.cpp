// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "mbs/mechanism/dynamics/mass_matrix.hpp"

/// M^-1 in O(n) by articulated bodies (Featherstone, Rigid Body Dynamics Algorithms, ch. 7), extended to
/// modal coordinates.  With V_b the twist of body b about Bo in W, x_b its own velocity coordinates (of its
/// joint, then its modes, s_b' = [0 1] x_b = E x_b) and a the parent,
///
///     V_b = V_in + K_b x_b,     V_in = X_b V_a + N_b s_a'
///
/// The kinetic energy of b and all outboard of it, after their coordinates have been eliminated, is a form in
/// (V_b, s_b') with the blocks I, C, M.  Eliminating x_b too leaves, inwards,
///
///     U = I K + C E,     D = K^T U + E^T (C^T K + M E),     I <- I - U D^-1 U^T
///     I_a += X^T I X,     C_a += X^T I N,     M_a += N^T I N
///
/// and M x = r is solved by one sweep inwards and one outwards:
///
///     u = r_b - K^T p - E^T q,     p <- p + U D^-1 u,     p_a += X^T p,     q_a += N^T p
///     x_b = D^-1 (u - U^T V_in)
namespace flexura::mbs {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// The lower triangle becomes Cholesky's factor; false at a pivot that is not positive.
bool factor_in_place(RowMajor& A) {
  const auto n = A.rows();
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < i; ++j)
      A(i, j) = (A(i, j) - A.row(i).head(j).dot(A.row(j).head(j))) / A(j, j);
    const double pivot = A(i, i) - A.row(i).head(i).squaredNorm();
    if (!(pivot > 1e-14 * A(i, i))) return false;
    A(i, i) = std::sqrt(pivot);
  }
  return true;
}

template <class Vector>
void solve_lower(const RowMajor& L, Vector&& x) {
  for (Eigen::Index i = 0; i < L.rows(); ++i) {
    double sum = x(i);
    for (Eigen::Index j = 0; j < i; ++j) sum -= L(i, j) * x(j);
    x(i) = sum / L(i, i);
  }
}

template <class Vector>
void solve_upper(const RowMajor& L, Vector&& x) {
  for (Eigen::Index i = L.rows() - 1; i >= 0; --i) {
    x(i) /= L(i, i);
    for (Eigen::Index j = 0; j < i; ++j) x(j) -= L(i, j) * x(i);
  }
}

}  // namespace

bool MassMatrix::factor(const Motion& motion, Inertias& inertias) const {
  for (auto it = tree_.order.rbegin(); it != tree_.order.rend(); ++it) {
    const int b = *it;
    const TreeBody& t = tree_.bodies[b];
    const Motion::Body& moves = motion.bodies[b];
    Inertias::Body& body = inertias.bodies[b];
    Inertias::Articulated& a = inertias.articulated[b];
    a.K = inertias.K[b];
    a.U.noalias() = body.I_c * a.K;
    a.U.rightCols(t.m) += body.C_c;
    a.L.noalias() = a.K.transpose() * a.U;
    a.L.bottomRows(t.m).noalias() += body.C_c.transpose() * a.K;
    a.L.bottomRightCorner(t.m, t.m) += body.M_c;
    if (!factor_in_place(a.L)) return false;
    // U becomes U L^-T: then U D^-1 U^T = U U^T.
    for (int i = 0; i < 6; ++i) solve_lower(a.L, a.U.row(i));
    if (t.parent == 0) continue;
    body.I_c.noalias() -= a.U * a.U.transpose();
    const Pose& X_W_parent = motion.bodies[t.parent].X_WB;
    Inertias::Body& parent = inertias.bodies[t.parent];
    const Vector3d& p_in = motion.kin.markers[t.marker_in].X_WP.p;
    a.r = moves.X_WB.p - X_W_parent.p;
    const Matrix6d X = transport_twist(a.r), IX = body.I_c * X;
    parent.I_c.noalias() += X.transpose() * IX;
    if (!tree_.is_carried[t.marker_in]) continue;  // N stays zero
    const auto& map = motion.local[t.marker_in].node.map;
    a.N.topRows<3>().noalias() = X_W_parent.R * map.topRows<3>();
    a.N.bottomRows<3>().noalias() = X_W_parent.R * map.bottomRows<3>();
    a.N.bottomRows<3>().noalias() -= skew(moves.X_WB.p - p_in) * a.N.topRows<3>();
    parent.C_c.noalias() += IX.transpose() * a.N;
    auto IN = inertias.H.leftCols(a.N.cols());
    IN.noalias() = body.I_c * a.N;
    parent.M_c.noalias() += a.N.transpose() * IN;
  }
  return true;
}

void MassMatrix::solve(Inertias& inertias, VectorRef x) const {
  for (int b : tree_.order) {
    inertias.articulated[b].p.setZero();
    inertias.articulated[b].q.setZero();
  }
  for (auto it = tree_.order.rbegin(); it != tree_.order.rend(); ++it) {
    const TreeBody& t = tree_.bodies[*it];
    Inertias::Articulated& a = inertias.articulated[*it];
    auto u = x.segment(tree_.places[t.joint].i_v, a.K.cols());
    u.noalias() -= a.K.transpose() * a.p;
    u.tail(t.m) -= a.q;
    solve_lower(a.L, u);
    if (t.parent == 0) continue;
    a.p.noalias() += a.U * u;
    Inertias::Articulated& parent = inertias.articulated[t.parent];
    const Vector3d f = a.p.tail<3>();
    parent.p.head<3>() += a.p.head<3>() + a.r.cross(f);
    parent.p.tail<3>() += f;
    if (a.N.cols() > 0) parent.q.noalias() += a.N.transpose() * a.p;
  }
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    Inertias::Articulated& a = inertias.articulated[b];
    a.V.setZero();
    if (t.parent != 0) {
      const Inertias::Articulated& parent = inertias.articulated[t.parent];
      const Vector3d w = parent.V.head<3>();
      a.V = parent.V;
      a.V.tail<3>() += w.cross(a.r);
      if (a.N.cols() > 0)
        a.V.noalias() += a.N * x.segment(tree_.bodies[t.parent].i_v, tree_.bodies[t.parent].m);
    }
    auto u = x.segment(tree_.places[t.joint].i_v, a.K.cols());
    u.noalias() -= a.U.transpose() * a.V;
    solve_upper(a.L, u);
    a.V.noalias() += a.K * u;
  }
}

}  // namespace flexura::mbs
