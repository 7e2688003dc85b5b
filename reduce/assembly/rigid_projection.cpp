// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/rigid_projection.hpp"

#include <Eigen/QR>
#include <algorithm>

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

RigidProjection::RigidProjection(const MatrixXd& R_b, const std::vector<char>& is_rotation) : R_b_(R_b) {
  const Index n_b = R_b.rows();
  // The boundary's own size: how far a unit rotation about its middle moves its displacement dofs.
  MatrixXd R = R_b;
  Index n_moves = 0;
  Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
  for (Index b = 0; b < n_b; ++b)
    if (!is_rotation[b]) mean += R.row(b).tail<3>(), ++n_moves;
  double spread = 0.0, arm = 0.0;
  for (Index b = 0; b < n_b; ++b)
    if (!is_rotation[b]) {
      spread = std::max(spread, (R.row(b).tail<3>() - mean / static_cast<double>(n_moves)).norm());
      arm = std::max(arm, R.row(b).tail<3>().norm());
    }
  length_ = spread > 0.0 ? spread : arm > 0.0 ? arm : 1.0;
  size_.resize(n_b);
  for (Index b = 0; b < n_b; ++b) size_(b) = is_rotation[b] ? length_ : 1.0;
  R.rightCols<3>() /= length_;
  const MatrixXd A = size_.asDiagonal() * R;
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(A);
  G_ = qr.solve(MatrixXd(size_.asDiagonal()));
  G_.bottomRows<3>() /= length_;
  P_ = MatrixXd::Identity(n_b, n_b) - R_b * G_;
  // Dofs that only move rigidly have no strain: their rows of the projector are zero, not round-off (a few 1e-16 times the
  // condition of A), beside which the stiffness of all such dofs would be judged.
  constexpr double kStrainless = 1e-13;
  const MatrixXd scaled = size_.asDiagonal() * P_ * size_.cwiseInverse().asDiagonal();
  P_ = (scaled.array().abs() < kStrainless).select(0.0, P_);
}

MatrixXd RigidProjection::strain_free(const MatrixXd& K) const {
  // Six motions that hold the body are its rigid motions: what stands there is round-off.
  if (K.rows() == 6) return MatrixXd::Zero(6, 6);
  const MatrixXd B = P_.transpose() * K * P_;
  return 0.5 * (B + B.transpose());
}

MatrixXd RigidProjection::corrected(const MatrixXd& Psi, const MatrixXd& R_i) const {
  return Psi + (R_i - Psi * R_b_) * G_;
}

double RigidProjection::error(const MatrixXd& Psi, const MatrixXd& R_i) const {
  const MatrixXd off = R_i - Psi * R_b_;
  double worst = 0.0;
  for (Index c = 0; c < 6; ++c) worst = std::max(worst, off.col(c).norm() / R_i.col(c).norm());
  return worst;
}

}  // namespace flexura::reduce
