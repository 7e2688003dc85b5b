// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <functional>
#include <random>

#include "reduce/linalg/eigen/lanczos_basis.hpp"

namespace flexura::linalg {

/// The Krylov space of S = (K + shift M)^-1 M that block Lanczos (block_lanczos.hpp) grows block by block: V with
/// H = V^T M S V of all but the newest block, S V = V H + V_newest R E^T.
class LanczosSpace {
 public:
  /// Begins with a block of `block` vectors.  The problem must outlive it.
  LanczosSpace(const EigenProblem& problem, const VectorStorage& storage, Eigen::Index block,
               Eigen::Index capacity);

  /// Applies S to the newest block.
  void expand();
  /// S leaves the space as it is.
  bool exhausted() const { return newest_ == 0; }
  /// From s starting vectors powers of S make no more than s vectors of a multiple eigenvalue: so many more (0: a block) start beside
  /// them.  False where nothing is beside the space.
  bool begin_anew(Eigen::Index width = 0);
  Eigen::Index n_starting() const { return n_starting_; }  ///< vectors from which the space has come

  Eigen::Index size() const { return H_.rows(); }  ///< of H
  Eigen::Index size_with_newest() const { return basis_.size(); }
  bool is_full() const { return basis_.size() + std::max(block_, newest_) > capacity_; }
  Eigen::Index capacity() const { return capacity_; }
  void reserve(Eigen::Index capacity);

  /// All Ritz pairs H y = theta y, theta descending.
  struct RitzPairs {
    Eigen::VectorXd theta;
    Eigen::MatrixXd Y;
    Eigen::VectorXd estimate;  ///< relative residual of S
  };
  RitzPairs ritz_pairs() const;
  /// phi = S V y / theta of some of them.
  Eigen::MatrixXd vectors(const Eigen::MatrixXd& Y, const Eigen::VectorXd& theta) const;
  /// Thick restart: V Y and the newest block become the space.
  void restart(const Eigen::MatrixXd& Y, const Eigen::VectorXd& theta);

  int n_solves() const { return n_solves_; }
  int n_blocks() const { return n_blocks_; }

 private:
  void add_start(Eigen::Index width);

  const EigenProblem& problem_;
  Eigen::Index block_, capacity_;
  LanczosBasis basis_;
  std::mt19937_64 random_;
  Eigen::MatrixXd H_, R_;
  Eigen::Index newest_ = 0, applied_ = 0;  // widths of the newest block, and of the one before
  Eigen::Index n_starting_ = 0;
  int n_solves_ = 0, n_blocks_ = 0;
};

/// When the pairs of H are to be looked at: a look costs some 20 size^3, a block 8 n size b in orthogonalisation alone,
/// and looks are to be a quarter of that.  The pairs known so far, and how fast the worst of them becomes better, tell when
/// the rest will be.
class LanczosLooks {
 public:
  LanczosLooks(double n_rows, Eigen::Index block, Eigen::Index first)
      : n_rows_(n_rows), block_(static_cast<double>(block)), next_(first) {}
  bool due(Eigen::Index size) const { return size >= next_; }
  void set_next(Eigen::Index size) { next_ = size; }
  /// After a look that has found `known` of `target` pairs accurate, the worst of all `too_large` times larger than it may be.
  void plan(Eigen::Index size, Eigen::Index known, Eigen::Index target, double too_large);
  void forget() {  ///< at a restart
    looked_at_ = known_then_ = 0;
    too_large_then_ = 0.0;
  }

 private:
  double n_rows_, block_, too_large_then_ = 0.0;
  Eigen::Index next_, looked_at_ = 0, known_then_ = 0;
};

}  // namespace flexura::linalg
