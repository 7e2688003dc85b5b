// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/damping.hpp"

#include <algorithm>
#include <cmath>

#include "reduce/linalg/dense/dense.hpp"

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

void add_damping(Reduction& r, const DampingRule& rule) {
  if (r.D_se.size() == 0) r.D_se = MatrixXd::Zero(r.n(), r.n());
  const linalg::DenseEigen modes = linalg::generalized_eigen(r.K_se, r.M_se);
  const Eigen::Index n = r.n() - 6;
  const MatrixXd M_Y = r.M_se * modes.vectors.rightCols(n);
  Eigen::VectorXd rate(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const double omega =
        std::sqrt(std::max(0.0, modes.values(6 + j)));  // round-off of hinges within the part
    rate(j) = 2.0 * damping_ratio(rule, omega) * omega + rule.alpha;
  }
  r.D_se += M_Y * rate.asDiagonal() * M_Y.transpose() + rule.beta * r.K_se;
  r.D_se = (0.5 * (r.D_se + r.D_se.transpose())).eval();
}

}  // namespace flexura::reduce
