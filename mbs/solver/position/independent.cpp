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
  MatrixXd N = DQ * lu.inverse() * D(independent).cwiseInverse().asDiagonal();
  N(independent, Eigen::all).setIdentity();
  return N;
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

IndependentCoordinates independent_coordinates_beside(const MatrixXd& M, const MatrixXd& G,
                                                      const std::vector<int>& first) {
  const VectorXd D = units_of(M);
  const MatrixXd Q = free_motions(G, D);
  IndependentCoordinates out{first, MatrixXd::Zero(M.rows(), 0)};
  if (Q.cols() == 0) return out;
  // What the rows of `first` leave of the others' rows.
  MatrixXd left = Q.transpose();
  if (!first.empty()) {
    const Eigen::HouseholderQR<MatrixXd> qr(Q(first, Eigen::all).transpose());
    const MatrixXd spans = MatrixXd(qr.householderQ()).leftCols(static_cast<Eigen::Index>(first.size()));
    left -= spans * (spans.transpose() * left).eval();
    for (const int i : first) left.col(i).setZero();
  }
  const Eigen::ColPivHouseholderQR<MatrixXd> pivots(left);
  for (Eigen::Index k = 0; k < Q.cols() - static_cast<Eigen::Index>(first.size()); ++k)
    out.independent.push_back(static_cast<int>(pivots.colsPermutation().indices()(k)));
  double rcond = 0.0;
  out.N = followers(Q, D, out.independent, rcond);
  return out;
}

MatrixXd dependent_by_rows(const MatrixXd& M, const MatrixXd& G, const std::vector<int>& independent) {
  const Eigen::Index n_v = M.rows();
  MatrixXd Y = MatrixXd::Zero(n_v, G.rows());
  std::vector<bool> is_free(static_cast<std::size_t>(n_v), false);
  for (const int i : independent) is_free[static_cast<std::size_t>(i)] = true;
  std::vector<int> dependent;
  for (int i = 0; i < n_v; ++i)
    if (!is_free[static_cast<std::size_t>(i)]) dependent.push_back(i);
  if (dependent.empty() || G.rows() == 0) return Y;
  const VectorXd D = units_of(M)(dependent);
  const MatrixXd GD = G(Eigen::all, dependent) * D.asDiagonal();
  VectorXd E = GD.rowwise().norm();
  for (double& e : E) e = e > 0.0 ? 1.0 / e : 1.0;
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition(E.asDiagonal() * GD);
  Y(dependent, Eigen::all) = D.asDiagonal() * decomposition.pseudoInverse() * E.asDiagonal();
  return Y;
}

}  // namespace flexura::mbs
