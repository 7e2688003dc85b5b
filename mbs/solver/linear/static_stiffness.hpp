// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"

/// The stiffness of an equilibrium in independent coordinates z (independent.hpp),
///
///     K = N^T (d(G^T lambda - f)/dq) N,   dq = N z
///
/// with what dynamic and algebraic states answer to z statically, where c' = 0 and b = 0.  It comes from
/// Equations::tangents() and is as exact as they are.
namespace flexura::mbs {

struct StaticStiffness {
  Eigen::MatrixXd K;  ///< n_z x n_z: generalised forces on z that hold a displacement of z
  /// What the entries of K may lack (n_z x n_z), as independent random errors: round-off in units of the stiffness of
  /// their two coordinates, 1e-14 sqrt(K_ii K_jj), and what two evaluations beside each other differ by, which is the
  /// noise of elements whose derivatives are differences; for coordinates of joints also 1e-16 of the stiffest that
  /// hangs on them.
  Eigen::MatrixXd error;
  std::vector<int> independent;
  std::vector<std::string> names;  ///< of the velocity coordinates that make up z
  Eigen::MatrixXd N;               ///< n_v x n_z
};

/// At a state of equilibrium with its multipliers. `independent`: coordinates to take in place of those that
/// determine the others best; the result has none where these no longer do.  Throws std::runtime_error where a
/// dynamic state has no static value.
StaticStiffness static_stiffness(const Equations& eq, const State& s,
                                 const std::vector<int>* independent = nullptr);

/// Of l^T K x by the errors of K: sqrt(sum l_i^2 E_ij^2 x_j^2).
double noise_of(const Eigen::VectorXd& l, const Eigen::MatrixXd& error, const Eigen::VectorXd& x);

/// A number beyond so many times its noise is one.
inline constexpr double kBeyondNoise = 3.0;

}  // namespace flexura::mbs
