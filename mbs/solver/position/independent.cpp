// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/independent.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd units_of(const MatrixXd& M) {
  VectorXd D(M.rows());
  for (Eigen::Index i = 0; i < M.rows(); ++i) D(i) = M(i, i) > 0.0 ? 1.0 / std::sqrt(M(i, i)) : 1.0;
  return D;
}

// Orthonormal columns that span the null space of G D.
MatrixXd free_motions(const MatrixXd& G, const VectorXd& D) {
  const Eigen::Index n_v = D.size();
  MatrixXd Q = MatrixXd::Identity(n_v, n_v);
  if (G.rows() == 0) return Q;
  MatrixXd GD = (G * D.asDiagonal()).transpose();
  for (Eigen::Index k = 0; k < GD.cols(); ++k)
    if (const double norm = GD.col(k).norm(); norm > 0.0) GD.col(k) /= norm;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(GD);
  qr.setThreshold(1e-10);
  return (qr.householderQ() * Q).rightCols(n_v - qr.rank());
}

MatrixXd followers(const MatrixXd& Q, const VectorXd& D, const std::vector<int>& independent, double& rcond) {
  const MatrixXd DQ = D.asDiagonal() * Q;
  const Eigen::PartialPivLU<MatrixXd> lu(Q(independent, Eigen::all));
  rcond = lu.rcond();
  return DQ * lu.inverse() * D(independent).cwiseInverse().asDiagonal();
}

}  // namespace

IndependentCoordinates independent_coordinates(const MatrixXd& M, const MatrixXd& G) {
  const VectorXd D = units_of(M);
  const MatrixXd Q = free_motions(G, D);
  IndependentCoordinates out;
  if (Q.cols() == 0) {  // nothing moves but dynamic states
    out.N.setZero(M.rows(), 0);
    return out;
  }
  const Eigen::ColPivHouseholderQR<MatrixXd> pivots(Q.transpose());
  for (Eigen::Index k = 0; k < Q.cols(); ++k)
    out.independent.push_back(static_cast<int>(pivots.colsPermutation().indices()(k)));
  std::sort(out.independent.begin(), out.independent.end());
  double rcond = 0.0;
  out.N = followers(Q, D, out.independent, rcond);
  return out;
}

IndependentCoordinates independent_coordinates(const MatrixXd& M, const MatrixXd& G,
                                               const std::vector<int>& wanted) {
  const VectorXd D = units_of(M);
  const MatrixXd Q = free_motions(G, D);
  IndependentCoordinates out{wanted, MatrixXd::Zero(M.rows(), 0)};
  if (Q.cols() == 0 && wanted.empty()) return out;
  double rcond = 0.0;
  if (Q.cols() == static_cast<Eigen::Index>(wanted.size())) out.N = followers(Q, D, wanted, rcond);
  if (!(rcond > 1e-8)) return {{}, MatrixXd::Zero(M.rows(), 0)};
  return out;
}

}  // namespace flexura::mbs
