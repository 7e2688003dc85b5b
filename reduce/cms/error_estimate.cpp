// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/error_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "reduce/linalg/dense.hpp"

namespace flexura::reduce {
namespace {

constexpr double kCloseGap = 0.05;  // of the eigenvalue

void require_estimate(const Reduction& reduction) {
  if (reduction.dropped.rows() != reduction.n_b)
    throw std::invalid_argument(
        "the reduction was made without its error estimate: ask for it in the options");
}

}  // namespace

std::vector<ModeError> mode_errors(const Reduction& reduction, const std::vector<int>& held) {
  require_estimate(reduction);
  std::vector<int> kept;
  for (int k = 0; k < reduction.n(); ++k)
    if (std::find(held.begin(), held.end(), k) == held.end()) kept.push_back(k);
  const linalg::DenseEigen modes =
      linalg::generalized_eigen(reduction.K_se(kept, kept), reduction.M_se(kept, kept));
  // Rigid motions: as many as the stiffness of the boundary, with the held dofs away, leaves free.  They
  // stand out by ten powers of ten; elastic eigenvalues of one body do not spread that far from the largest
  // static one.
  const double elastic = 1e-9 * modes.values(modes.values.size() / 2);
  std::vector<ModeError> errors;
  for (Eigen::Index k = 0; k < modes.values.size(); ++k) {
    const double lambda = modes.values(k);
    if (lambda < elastic) continue;
    Eigen::VectorXd u_b = Eigen::VectorXd::Zero(reduction.n_b);
    for (std::size_t r = 0; r < kept.size(); ++r)
      if (kept[r] < reduction.n_b) u_b(kept[r]) = modes.vectors(static_cast<Eigen::Index>(r), k);
    const double estimate = lambda * u_b.dot(reduction.dropped * u_b);
    const double margin = 1.0 - lambda / reduction.omega2_dropped;
    errors.push_back(
        {lambda, estimate, margin > 0.0 ? estimate / margin : std::numeric_limits<double>::infinity(), true});
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
