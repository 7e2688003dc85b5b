// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

/// The system of saddle.hpp with unit diagonal of M and unit rows of G, for many bodies on short chains,
/// where M falls into blocks and a row of G meets few of them:
///
///     S = G M^-1 G^T,     S y = G M^-1 f - h,     x = M^-1 (f - G^T y)
///
/// by sparse Cholesky factors of M and S (SuiteSparse's AMD ordering through Eigen), refined once.  The cost
/// grows with the number of bodies, that of the dense way with its cube.
namespace flexura::mbs {

class SparseSaddle {
 public:
  SparseSaddle();
  ~SparseSaddle();

  /// M (n x n) with unit diagonal, G_T (n x n_lambda) with unit columns.  False where the matrices are small
  /// or full, M is near to not positive definite, or rows of G are near to depending on each other: these
  /// want the complete decomposition of the dense way.
  bool factor(const Eigen::MatrixXd& M, const Eigen::MatrixXd& G_T);

  double independence() const;  ///< see SaddleSolver

  /// x (n) and y (n_lambda) for f (n) and h (n_lambda).
  void solve(const Eigen::VectorXd& f, const Eigen::VectorXd& h, Eigen::VectorXd& x, Eigen::VectorXd& y);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::mbs
