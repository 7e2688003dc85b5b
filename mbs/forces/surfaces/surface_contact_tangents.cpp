// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/forces/surfaces/onset.hpp"
#include "mbs/forces/surfaces/surface_contact.hpp"
#include "mbs/kinematics/deformation_derivatives.hpp"

namespace flexura::mbs {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The depth's rate is - gap_z . z', so that p follows z by - (by_depth gap_z + by_rate gap_zz z').  Of the velocity against what is
// touched, v = p' - sum share_k y_k', the part v_t = v - n (n . v) slides, with n along gap_p:
//     d n = (1 - n n) d gap_p / |gap_p|,     d v_t = (1 - n n) dv - (n . v) dn - n (v . dn).
void SurfaceContact::slopes(const Touch& t, MatrixXd& by_place, MatrixXd& by_velocity) const {
  const TouchedSurface::Foot& foot = t.foot;
  const int n_z = foot.n();
  const double A = t.area, cover = foot.cover;
  const VectorXd p_by_place = -(t.law.by_depth * foot.gap_z + t.law.by_rate * (foot.gap_zz * t.z_dot));
  VectorXd N_by_place = A * cover * p_by_place;
  if (foot.is_at_end) N_by_place += A * t.law.p * foot.cover_z;
  const VectorXd N_by_velocity = -A * cover * t.law.by_rate * foot.gap_z;
  by_place.noalias() = foot.gap_z * N_by_place.transpose();
  by_place += A * t.p * foot.gap_zz;
  if (foot.is_at_end) {
    by_place.noalias() += A * t.law.elastic * foot.cover_z * foot.gap_z.transpose();
    by_place -= A * t.law.energy * foot.cover_zz;
  }
  by_velocity.noalias() = foot.gap_z * N_by_velocity.transpose();
  if (!(friction_.mu > 0.0)) return;

  const auto V = static_cast<Eigen::Index>(foot.vertices.size());
  const Matrix3d across = Matrix3d::Identity() - t.n * t.n.transpose();
  using Rows3 = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  const Rows3 n_by_place = across * foot.gap_zz.topRows<3>() / foot.gap_z.head<3>().norm();
  Rows3 v_by_place = Rows3::Zero(3, n_z), sliding_by_velocity(3, n_z);
  sliding_by_velocity.leftCols<3>() = across;
  for (Eigen::Index k = 0; k < V; ++k) {
    v_by_place.noalias() -= t.z_dot.segment<3>(3 + 3 * k) * foot.share_z.row(k);
    sliding_by_velocity.middleCols<3>(3 + 3 * k) = -foot.share(k) * across;
  }
  const Rows3 sliding_by_place =
      across * v_by_place - t.n.dot(t.v) * n_by_place - t.n * (t.v.transpose() * n_by_place);
  const double speed = t.sliding.norm(), N = A * t.p;
  const Onset onset(speed, friction_.v_0);
  Matrix3d by_sliding = onset.phi * Matrix3d::Identity();
  if (speed > 0.0) by_sliding += onset.slope / speed * t.sliding * t.sliding.transpose();
  const Rows3 f_by_place = -friction_.mu * (onset.phi * t.sliding * N_by_place.transpose() +
                                            N * by_sliding * sliding_by_place),
              f_by_velocity = -friction_.mu * (onset.phi * t.sliding * N_by_velocity.transpose() +
                                               N * by_sliding * sliding_by_velocity);
  by_place.topRows<3>() += f_by_place;
  by_velocity.topRows<3>() += f_by_velocity;
  for (Eigen::Index k = 0; k < V; ++k) {
    by_place.middleRows<3>(3 + 3 * k) -= foot.share(k) * f_by_place + t.friction * foot.share_z.row(k);
    by_velocity.middleRows<3>(3 + 3 * k) -= foot.share(k) * f_by_velocity;
  }
}

void SurfaceContact::differentiate(const Kinematics& kin, const double*, Derivatives& d) const {
  if (kin.own.root[0] == 0) return;
  const View at = view(kin);
  const Matrix3d& R = at.rel.X_FM.R;
  const Vector3d w = at.rel.V.head<3>();
  const int m = at.s ? patch_->m() : 0, o = at.o ? at.m_o : 0;
  using Columns6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  Vector6d on_B = Vector6d::Zero();
  Eigen::Matrix<double, 6, 12> on_B_by = Eigen::Matrix<double, 6, 12>::Zero();
  // By s and s', by o and o'.
  Columns6 on_B_by_s = Columns6::Zero(6, m), on_B_by_s_dot = on_B_by_s, on_B_by_o = Columns6::Zero(6, o),
           on_B_by_o_dot = on_B_by_o;
  struct Modal {
    MatrixXd by, by_s, by_s_dot, by_o, by_o_dot;
    Modal(int rows, int m, int o)
        : by(MatrixXd::Zero(rows, 12)),
          by_s(MatrixXd::Zero(rows, m)),
          by_s_dot(by_s),
          by_o(MatrixXd::Zero(rows, o)),
          by_o_dot(by_o) {}
  };
  Modal s(m, m, o), other(o, m, o);
  MatrixXd K, D, J, X_by, X_by_s, X_by_s_dot, X_by_o, X_by_o_dot;
  for_touching(at, true, [&](const Touch& t) {
    slopes(t, K, D);
    const auto V = static_cast<Eigen::Index>(t.foot.vertices.size());
    const Vector3d f = t.force.head<3>();
    const Matrix3d r_x = skew(t.r), f_x = skew(f);
    on_B.head<3>() += t.r.cross(f);
    on_B.tail<3>() += f;
    // dp = dp_B + dtheta x r + R Phi ds;  dv = du + dw x r + w x (dtheta x r + R Phi ds) + dtheta x R Phi s' + R Phi ds'.
    const auto K_p = K.leftCols<3>(), D_p = D.leftCols<3>();
    X_by.resize(t.foot.n(), 12);
    X_by.leftCols<3>() = -K_p * r_x - D_p * (skew(w) * r_x + skew(t.turned_v));
    X_by.middleCols<3>(3) = K_p;
    X_by.middleCols<3>(6) = -D_p * r_x;
    X_by.rightCols<3>() = D_p;
    if (m > 0) {
      const auto Phi = patch_->shapes(t.node);
      X_by_s.noalias() = ((K_p + D_p * skew(w)) * R) * Phi;
      X_by_s_dot.noalias() = (D_p * R) * Phi;
    }
    if (o > 0) {
      J.resize(3 * V, o);
      for (Eigen::Index k = 0; k < V; ++k)
        J.middleRows<3>(3 * k) = touched_->shapes(t.foot.vertices[static_cast<std::size_t>(k)]);
      X_by_o.noalias() = K.rightCols(3 * V) * J;
      X_by_o_dot.noalias() = D.rightCols(3 * V) * J;
    }
    on_B_by.topRows<3>() += r_x * X_by.topRows<3>();
    on_B_by.topLeftCorner<3, 3>() += f_x * r_x;
    on_B_by.bottomRows<3>() += X_by.topRows<3>();
    const auto on_both = [&](const MatrixXd& X_by_c, Columns6& to) {
      to.topRows<3>().noalias() += r_x * X_by_c.topRows<3>();
      to.bottomRows<3>() += X_by_c.topRows<3>();
    };
    if (m > 0) {
      const auto Phi = patch_->shapes(t.node);
      on_both(X_by_s, on_B_by_s);
      on_both(X_by_s_dot, on_B_by_s_dot);
      on_B_by_s.topRows<3>().noalias() -= (f_x * R) * Phi;
      // R^T f: R turns with dtheta, -R^T (dtheta x f).
      Eigen::Matrix<double, 3, 12> in_B = R.transpose() * X_by.topRows<3>();
      in_B.leftCols<3>() += R.transpose() * f_x;
      s.by.noalias() += Phi.transpose() * in_B;
      s.by_s.noalias() += Phi.transpose() * (R.transpose() * X_by_s.topRows<3>());
      s.by_s_dot.noalias() += Phi.transpose() * (R.transpose() * X_by_s_dot.topRows<3>());
      if (o > 0) {
        s.by_o.noalias() += Phi.transpose() * (R.transpose() * X_by_o.topRows<3>());
        s.by_o_dot.noalias() += Phi.transpose() * (R.transpose() * X_by_o_dot.topRows<3>());
      }
    }
    if (o > 0) {
      on_both(X_by_o, on_B_by_o);
      on_both(X_by_o_dot, on_B_by_o_dot);
      other.by.noalias() += J.transpose() * X_by.bottomRows(3 * V);
      other.by_o.noalias() += J.transpose() * X_by_o.bottomRows(3 * V);
      other.by_o_dot.noalias() += J.transpose() * X_by_o_dot.bottomRows(3 * V);
      if (m > 0) {
        other.by_s.noalias() += J.transpose() * X_by_s.bottomRows(3 * V);
        other.by_s_dot.noalias() += J.transpose() * X_by_s_dot.bottomRows(3 * V);
      }
    }
  });
  d.between(F_, B_, on_B);
  d.by_relative(F_, B_, on_B_by);
  if (m == 0 && o == 0) return;
  DeformationDerivatives& deformation = d.deformations();
  for (int i = 0; i < m; ++i) {
    d.by_deformation(body_, i, on_B_by_s.col(i));
    deformation.by_deformation_rate(body_, i, on_B_by_s_dot.col(i));
  }
  for (int i = 0; i < o; ++i) {
    d.by_deformation(other_, i, on_B_by_o.col(i));
    deformation.by_deformation_rate(other_, i, on_B_by_o_dot.col(i));
  }
  const auto modal_forces = [&](int body, const Modal& of) {
    deformation.modal_forces(body, F_, B_, of.by);
    if (m > 0) deformation.modal_forces_by(body, body_, of.by_s, of.by_s_dot);
    if (o > 0) deformation.modal_forces_by(body, other_, of.by_o, of.by_o_dot);
  };
  if (m > 0) modal_forces(body_, s);
  if (o > 0) modal_forces(other_, other);
}

}  // namespace flexura::mbs
