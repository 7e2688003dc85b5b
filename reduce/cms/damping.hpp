// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/cms/result/reduction.hpp"
#include "reduce/linalg/dense/dense.hpp"

/// Damping by what a measurement gives: ratios to critical over frequency.
///
///     D = M Y diag(2 zeta(omega_j) omega_j) Y^T M,     Y the elastic modes of the free superelement,
///
/// gives each of them its ratio exactly (Y^T M Y = 1) and leaves rigid motion free.  R. W. Clough, J.
/// Penzien, Dynamics of Structures, 12-3.  Rayleigh: D = alpha M + beta K, without the rigid motion's share
/// of alpha M.
namespace flexura::reduce {

struct DampingRule {
  std::vector<double> omega, ratio;  ///< ascending; between them linear, beyond the ends constant
  double critical_above = 0.0;       ///< [rad/s]: ratio 1 from here; 0: nowhere
  double alpha = 0.0;                ///< [1/s]
  double beta = 0.0;                 ///< [s]
};

/// The ratio at a frequency [rad/s]; 0 for an empty table.
double damping_ratio(const DampingRule& rule, double omega);

/// Modes of K, M (n x n) without the six rigid motions R (n x 6: translations, rotations), which are taken out exactly: the
/// eigenvectors of the six lowest eigenvalues are not they where hinges within the part have such values, too.
/// Y^T M Y = 1, Y^T M R = 0, n - 6 of them.
linalg::DenseEigen modes_beside_rigid(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M,
                                      const Eigen::MatrixXd& R);

/// Adds the rule's matrix to reduction.D_se.
void add_damping(Reduction& reduction, const DampingRule& rule);

}  // namespace flexura::reduce
