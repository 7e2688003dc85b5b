// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

/// A small eigenvalue solver for beam tests: subspace iteration on (K + shift M)^-1 M (K.-J. Bathe, Finite
/// Element Procedures, section 11.6).  Beam eigenvalues grow like k^4, so a few iterations reach round-off.
namespace flexura::beam::testing {

struct Modes {
  Eigen::VectorXd omega2;  ///< ascending
  Eigen::MatrixXd shapes;  ///< n x count, M-normalised, zero at fixed dofs
};

/// `fixed` dofs are taken out.  `shift` > 0 makes K + shift M definite for free bodies; choose it below the
/// first eigenvalue above zero.
Modes lowest_modes(const Eigen::SparseMatrix<double>& K, const Eigen::SparseMatrix<double>& M,
                   const std::vector<int>& fixed, int count, double shift = 0.0);

/// Static displacements for a load with `fixed` dofs held.
Eigen::VectorXd static_solution(const Eigen::SparseMatrix<double>& K, const Eigen::VectorXd& load,
                                const std::vector<int>& fixed);

}  // namespace flexura::beam::testing
