// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/damping.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "reduce/assembly/input/rigid_motion.hpp"

namespace flexura::reduce {

using Eigen::MatrixXd;

double damping_ratio(const DampingRule& rule, double omega) {
  if (rule.critical_above > 0.0 && omega >= rule.critical_above) return 1.0;
  if (rule.omega.empty()) return 0.0;
  if (omega <= rule.omega.front()) return rule.ratio.front();
  for (std::size_t k = 1; k < rule.omega.size(); ++k) {
    if (omega > rule.omega[k]) continue;
    const double t = (omega - rule.omega[k - 1]) / (rule.omega[k] - rule.omega[k - 1]);
    return (1.0 - t) * rule.ratio[k - 1] + t * rule.ratio[k];
  }
  return rule.ratio.back();
}

linalg::DenseEigen modes_beside_rigid(const MatrixXd& K, const MatrixXd& M, const MatrixXd& R) {
  // Rotations about the mass centre, lest those of a body far away be translations; rows of one size.
  MatrixXd M_R = M * R;
  const auto t = R.leftCols<3>();
  const MatrixXd centre =
      (t.transpose() * M_R.leftCols<3>()).ldlt().solve(t.transpose() * M_R.rightCols<3>());
  M_R.rightCols<3>() -= (M_R.leftCols<3>() * centre).eval();
  const Eigen::VectorXd unit = M.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::HouseholderQR<MatrixXd> qr(unit.asDiagonal() * M_R);
  const MatrixXd Q = qr.householderQ(), N = unit.asDiagonal() * Q.rightCols(M.rows() - 6);
  linalg::DenseEigen modes = linalg::generalized_eigen(N.transpose() * K * N, N.transpose() * M * N);
  modes.vectors = (N * modes.vectors).eval();
  return modes;
}

void add_damping(Reduction& r, const DampingRule& rule) {
  if (r.D_se.size() == 0) r.D_se = MatrixXd::Zero(r.n(), r.n());
  MatrixXd R = MatrixXd::Zero(r.n(), 6);
  for (const ReducedInterface& interface : r.interfaces) {
    const Eigen::Matrix<double, 6, 6> motion = node_motion_at(interface.point);
    Eigen::Index row = interface.first_dof;
    for (const int direction : interface.directions) R.row(row++) = motion.row(direction);
  }
  const linalg::DenseEigen modes = modes_beside_rigid(r.K_se, r.M_se, R);
  const MatrixXd M_Y = r.M_se * modes.vectors;
  // Of hinges within the part round-off stands for 0, below it as well.
  const Eigen::VectorXd omega = modes.values.cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd rate =
      omega.unaryExpr([&](double w) { return 2.0 * damping_ratio(rule, w) * w + rule.alpha; });
  r.D_se += M_Y * rate.asDiagonal() * M_Y.transpose() + rule.beta * r.K_se;
  r.D_se = (0.5 * (r.D_se + r.D_se.transpose())).eval();
}

}  // namespace flexura::reduce
