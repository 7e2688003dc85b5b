// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/downhill.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>

namespace flexura::mbs {
namespace {

// Eigenvalues of the symmetric part, ascending.
Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& H) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (H + H.transpose()), Eigen::EigenvaluesOnly)
      .eigenvalues();
}

// In units of stiffness, where Cholesky's pivots are as exact as 1e-14 of the largest: a tenth of the work of
// eigenvalues, and near an equilibrium all that is asked.
bool is_definite(const Eigen::MatrixXd& H) {
  constexpr double kRoundOff = 1e-14;
  Eigen::MatrixXd S = 0.5 * (H + H.transpose());
  S.diagonal().array() -= kRoundOff * S.diagonal().cwiseAbs().maxCoeff() * static_cast<double>(S.rows());
  return Eigen::LLT<Eigen::MatrixXd>(S).info() == Eigen::Success;
}

}  // namespace

Eigen::MatrixXd on_null_space(const Eigen::MatrixXd& K, const Eigen::MatrixXd& G, const Eigen::VectorXd& unit,
                              const Eigen::VectorXd& row_unit) {
  const Eigen::MatrixXd H = unit.asDiagonal() * K * unit.asDiagonal();
  if (G.rows() == 0) return H;
  const Eigen::MatrixXd rows = row_unit.asDiagonal() * G * unit.asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(rows.transpose());
  qr.setThreshold(1e-10);
  Eigen::MatrixXd N = Eigen::MatrixXd::Identity(K.rows(), K.rows());
  N = (qr.householderQ() * N).rightCols(K.rows() - qr.rank()).eval();
  return N.transpose() * H * N;
}

Eigen::VectorXd units_of_stiffness(const Eigen::MatrixXd& K, const Eigen::MatrixXd& G,
                                   const Eigen::VectorXd& by_mass) {
  const Eigen::VectorXd k = K.diagonal().cwiseAbs(), m = by_mass.cwiseAbs2();
  const double stiffest = k.cwiseProduct(m).maxCoeff();
  if (!(stiffest > 0.0)) return {};
  Eigen::VectorXd least = stiffest * m.cwiseInverse();
  for (Eigen::Index i = 0; i < least.size(); ++i)
    least(i) *= G.rows() == 0 || G.col(i).isZero(0.0) ? 1e-30 : 1e-10;
  return k.cwiseMax(least).cwiseSqrt().cwiseInverse();
}

double downhill_shift(const Eigen::MatrixXd& K, const Eigen::MatrixXd& G, const Eigen::VectorXd& unit,
                      const Eigen::VectorXd& row_unit, double floor) {
  if (K.rows() == 0) return 0.0;
  // Definite or not is judged in units in which every coordinate is as stiff as the others: sections of
  // thin beams are 1e12 times stiffer than their bending in the norm of the masses.
  const Eigen::VectorXd by_stiffness = units_of_stiffness(K, G, unit);
  if (by_stiffness.size() > 0) {
    const Eigen::MatrixXd H = on_null_space(K, G, by_stiffness, row_unit);
    if (H.cols() == 0) return 0.0;
    if (is_definite(H)) return 0.0;
  }
  const Eigen::MatrixXd H = on_null_space(K, G, unit, row_unit);
  if (H.cols() == 0) return 0.0;
  const Eigen::VectorXd mu = symmetric_eigenvalues(H);
  // As stiff as the softest direction is unstable, and never below a part of the rest.
  return 2.0 * std::max(-mu(0), 0.0) + floor * mu.cwiseAbs().maxCoeff();
}

bool Stride::stands(double slope, double ahead, double& part) {
  constexpr double kFirst = 0.5, kLongest = 8.0, kUp = 0.5;
  if (!(slope < 0.0)) return true;  // no way down: constraints that are still open, moments without energy
  if (!(ahead <= -kUp * slope)) {
    part *= std::max(0.1, slope / (slope - ahead));
    longest_ = kFirst;
    return false;
  }
  longest_ = ahead < kUp * slope ? std::min(2.0 * longest_, kLongest) : std::max(0.5 * longest_, kFirst);
  return true;
}

}  // namespace flexura::mbs
