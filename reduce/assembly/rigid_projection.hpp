// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// Rigid motions of the boundary, known exactly, taken out of matrices that hold them to the digits of a solve.
///
/// R_b (n_b x 6) are the rigid motions of the boundary dofs.  In the scalar product W, which gives rotations the
/// length that makes them displacements, u_b = R_b G u_b + P u_b splits every boundary motion into a rigid one
/// and the rest, P R_b = 0.  A symmetric K whose rigid motions cost nothing but round-off becomes P^T K P, for
/// which they cost nothing at all, and shapes Psi that should move rigidly with them, Psi R_b = R_i, become
///
///     Psi + (R_i - Psi R_b) G.
///
/// Solves with thin or slender bodies lose as many digits as the condition of K_ii has; these are not lost.
namespace flexura::reduce {

class RigidProjection {
 public:
  /// `is_rotation` says for each boundary dof whether its unit is [rad].  R_b must have rank 6.
  RigidProjection(const Eigen::MatrixXd& R_b, const std::vector<char>& is_rotation);

  /// P^T K P; zero where there are six boundary dofs, whose motions are all rigid.
  Eigen::MatrixXd strain_free(const Eigen::MatrixXd& K) const;
  /// Psi + (R_i - Psi R_b) G; `R_i` n_i x 6 moves as R_b does.
  Eigen::MatrixXd corrected(const Eigen::MatrixXd& Psi, const Eigen::MatrixXd& R_i) const;
  /// |R_i - Psi R_b| over |R_i|, columns of one size: the digits that the solve had.
  double error(const Eigen::MatrixXd& Psi, const Eigen::MatrixXd& R_i) const;

 private:
  Eigen::MatrixXd R_b_, G_, P_;  ///< n_b x 6, 6 x n_b, n_b x n_b
  Eigen::VectorXd size_;         ///< n_b: square roots of W
  double length_ = 1.0;
};

}  // namespace flexura::reduce
