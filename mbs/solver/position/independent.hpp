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

/// `first`, which G leaves independent of each other, then as many more as determine the others, `first` foremost.
IndependentCoordinates independent_coordinates_beside(const Eigen::MatrixXd& M, const Eigen::MatrixXd& G,
                                                      const std::vector<int>& first);

/// Y (n_v x n_lambda), zero in the rows of z: dq = N z - Y h where G dq = -h. M gives the sizes.
Eigen::MatrixXd dependent_by_rows(const Eigen::MatrixXd& M, const Eigen::MatrixXd& G,
                                  const std::vector<int>& independent);

}  // namespace flexura::mbs
