// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

/// Coordinates z of a mechanism's own that determine all the others.
namespace flexura::mbs {

struct IndependentCoordinates {
  std::vector<int> independent;  ///< velocity coordinates that make up z, ascending
  Eigen::MatrixXd N;             ///< n_v x n_z: dq = N z, with G N = 0
};

/// Those that determine the others best: by column pivoting on a basis of the null space of G D, D = M_ii^-1/2.
/// M (n_v x n_v), G (n_lambda x n_v).
IndependentCoordinates independent_coordinates(const Eigen::MatrixXd& M, const Eigen::MatrixXd& G);

/// `wanted` in their place; none where these do not determine the others.
IndependentCoordinates independent_coordinates(const Eigen::MatrixXd& M, const Eigen::MatrixXd& G,
                                               const std::vector<int>& wanted);

}  // namespace flexura::mbs
