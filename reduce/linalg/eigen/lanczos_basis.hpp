// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "reduce/linalg/eigen/eigen_problem.hpp"

namespace flexura::linalg {

/// Room for so many vectors of length n, one after the other; what is there is kept.
using VectorStorage = std::function<double*(Eigen::Index columns)>;

/// The M-orthonormal basis V of block Lanczos (block_lanczos.hpp).
class LanczosBasis {
 public:
  /// Without `storage` it has memory of its own.  The problem must outlive it.
  LanczosBasis(const EigenProblem& problem, VectorStorage storage, Eigen::Index capacity);

  Eigen::Index size() const { return size_; }
  auto vectors(Eigen::Index first, Eigen::Index count) const { return V_.middleCols(first, count); }

  /// M times the newest block, for S to be applied to; it is kept for the recurrence below.
  const Eigen::MatrixXd& multiply_newest_by_M(Eigen::Index width);
  /// Makes W orthogonal to the basis and to itself and appends it; what is round-off of W's own size is left
  /// out. On return W_before = V_old C + V_new R.
  void append(Eigen::MatrixXd W, Eigen::MatrixXd& C, Eigen::MatrixXd& R);
  void reserve(Eigen::Index capacity);
  /// Replaces the basis by V Y and the last block.
  void restart(const Eigen::MatrixXd& Y, Eigen::Index last_block);

 private:
  Eigen::MatrixXd orthonormalise(Eigen::MatrixXd W, Eigen::MatrixXd MW, double scale);

  const EigenProblem& problem_;
  VectorStorage storage_;
  Eigen::MatrixXd own_;
  Eigen::Map<Eigen::MatrixXd> V_;
  Eigen::MatrixXd M_newest_,
      M_before_;  // M times the newest block and the one before; empty where not known
  Eigen::Index size_ = 0;
};

}  // namespace flexura::linalg
