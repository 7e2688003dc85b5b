// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/errors/error_estimate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {
namespace {

constexpr double kCloseGap = 0.05;  // of the eigenvalue

void require_estimate(const Reduction& reduction) {
  if (reduction.dropped.rows() != reduction.n_b)
    throw std::invalid_argument(
        "the reduction was made without its error estimate: ask for it in the options");
}

// Eigenvalues with the residual shapes X = F_rs Mhat beside the reduced model's own: on `kept` columns
//
//     [ K_se 0 ; 0 Omega_d^2 ],   [ M_se C ; C^T 1 ],   C = [ Mhat^T X ; 0 ] Y,
//
// where Y makes X^T M X = growth the identity and X^T K X = Mhat^T X =
// dropped the diagonal Omega_d^2.  None where the growth is not known, or where round-off alone makes the
// shapes, whose mass is then not positive: the leading order will do.
Eigen::VectorXd enlarged_eigenvalues(const Reduction& r, const std::vector<int>& kept) {
  if (r.dropped_growth.size() == 0 || !(r.dropped_growth.diagonal().maxCoeff() > 0.0)) return {};
  // Shapes that differ by round-off only are one.
  constexpr double kDependent = 1e-10;
  const Eigen::VectorXd scale = r.dropped_growth.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const linalg::DenseEigen growth =
      linalg::symmetric_eigen(scale.asDiagonal() * r.dropped_growth * scale.asDiagonal());
  Eigen::Index n_x = 0;
  while (n_x < growth.values.size() && growth.values(growth.values.size() - 1 - n_x) > kDependent) ++n_x;
  if (n_x == 0) return {};  // a mass without a positive direction: round-off
  Eigen::MatrixXd Y = scale.asDiagonal() * growth.vectors.rightCols(n_x) *
                      growth.values.tail(n_x).cwiseSqrt().cwiseInverse().asDiagonal();
  const linalg::DenseEigen own = linalg::symmetric_eigen(Y.transpose() * r.dropped * Y);
  Y = (Y * own.vectors).eval();
  const Eigen::MatrixXd coupling = r.dropped * Y;
  const auto n = static_cast<Eigen::Index>(kept.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + n_x, n + n_x),
                  M = Eigen::MatrixXd::Identity(n + n_x, n + n_x);
  K.topLeftCorner(n, n) = r.K_se(kept, kept);
  M.topLeftCorner(n, n) = r.M_se(kept, kept);
  // No dropped shape is softer than the first dropped mode; what says so is round-off.
  K.diagonal().tail(n_x) = own.values.cwiseMax(std::min(r.omega2_dropped, own.values.maxCoeff()));
  for (Eigen::Index row = 0; row < n; ++row)
    if (kept[row] < r.n_b) M.row(row).tail(n_x) = coupling.row(kept[row]);
  M.bottomLeftCorner(n_x, n) = M.topRightCorner(n, n_x).transpose();
  if (Eigen::LLT<Eigen::MatrixXd>(M).info() != Eigen::Success) return {};
  return linalg::generalized_eigen(K, M).values;
}

}  // namespace

std::vector<ModeError> mode_errors(const Reduction& reduction, const std::vector<int>& held) {
  require_estimate(reduction);
  std::vector<int> kept;
  for (int k = 0; k < reduction.n(); ++k)
    if (std::find(held.begin(), held.end(), k) == held.end()) kept.push_back(k);
  const linalg::DenseEigen modes =
      linalg::generalized_eigen(reduction.K_se(kept, kept), reduction.M_se(kept, kept));
  const double elastic = least_elastic(modes.values);
  const Eigen::VectorXd enlarged = enlarged_eigenvalues(reduction, kept);
  std::vector<ModeError> errors;
  for (Eigen::Index k = 0; k < modes.values.size(); ++k) {
    const double lambda = modes.values(k);
    if (lambda <= elastic) continue;
    Eigen::VectorXd u_b = Eigen::VectorXd::Zero(reduction.n_b);
    for (std::size_t r = 0; r < kept.size(); ++r)
      if (kept[r] < reduction.n_b) u_b(kept[r]) = modes.vectors(static_cast<Eigen::Index>(r), k);
    // Where response shapes hold all that an interface asks for, what is dropped is round-off of either sign.
    const double leading = std::max(0.0, lambda * u_b.dot(reduction.dropped * u_b));
    const double margin = 1.0 - lambda / reduction.omega2_dropped;
    const double estimate = enlarged.size() > 0 ? std::max(0.0, lambda / enlarged(k) - 1.0) : leading;
    const double safe = margin > 0.0 ? leading / margin : std::numeric_limits<double>::infinity();
    errors.push_back({lambda, estimate, safe, true});
  }
  // Errors as large as the gap between two eigenvalues mix their modes, and the estimates with them.
  for (std::size_t k = 0; k + 1 < errors.size(); ++k) {
    const double gap = (errors[k + 1].omega2 - errors[k].omega2) / errors[k + 1].omega2;
    if (gap < std::max(kCloseGap, 2.0 * (errors[k].estimate + errors[k + 1].estimate)))
      errors[k].isolated = errors[k + 1].isolated = false;
  }
  return errors;
}

double interface_error(const Reduction& reduction, double omega) {
  require_estimate(reduction);
  const double omega2 = omega * omega, margin = 1.0 - omega2 / reduction.omega2_dropped;
  if (!(margin > 0.0)) return std::numeric_limits<double>::infinity();
  const Eigen::MatrixXd M_bb = reduction.M_se.topLeftCorner(reduction.n_b, reduction.n_b);
  return omega2 / margin * linalg::generalized_eigen(reduction.dropped, M_bb).values.maxCoeff();
}

}  // namespace flexura::reduce
