// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "mbs/equations/equations.hpp"

/// The saddle-point system that accelerations, impulses and projections share:
///
///     [ M  G^T ] [ x ]   [ r ]
///     [ G   0  ] [ y ] = [ h ]
///
/// solved on the scaled matrices D M D (unit diagonal) and E G D (unit rows) through B = L^-1 G^T with M = L
/// L^T and a complete orthogonal decomposition of B.  Where rows of G depend on each other, x is unique and y
/// is the one of least norm in the scaled rows; h is then met in the least-squares sense.
namespace flexura::mbs {

class SaddleSolver {
 public:
  SaddleSolver();
  ~SaddleSolver();

  /// M (n_v x n_v), G (n_lambda x n_v).  `is_free` (n_v, or empty for all) says which entries of x may differ
  /// from 0. Throws std::runtime_error naming (through eq) the velocity coordinate where M is not positive
  /// definite.
  void factor(const Equations& eq, const Eigen::MatrixXd& M, const Eigen::MatrixXd& G,
              const std::vector<bool>& is_free = {});

  /// x (n_v) and y (n_lambda) for r (n_v) and h (n_lambda).
  void solve(const Eigen::VectorXd& r, const Eigen::VectorXd& h, Eigen::VectorXd& x, Eigen::VectorXd& y);

  int rank() const;  ///< of G
  /// Least over largest pivot of B, about its least singular value over its largest: how near the rows of G are to
  /// depending on each other. 1 without rows.
  double independence() const;
  const Eigen::VectorXd& row_scale() const;     ///< E: 1 / norm of the rows of G D (0 for a row of zeros)
  const Eigen::VectorXd& column_scale() const;  ///< D: 1 / sqrt(M_ii)

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::mbs
