// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mbs/equations/equations.hpp"

/// The kinematic map p' = T(p) w splits into small blocks (one number for a hinge, four for a ball joint).
/// This class finds the blocks once and then evaluates T, T^+ and A = d(T(p) w)/dp with as many calls as the
/// largest block is wide.
namespace flexura::mbs {

class KinematicBlocks {
 public:
  struct Block {
    std::vector<int> p, v;      ///< indices of positions and velocities
    Eigen::MatrixXd T, A;       ///< p x v, p x p
    Eigen::MatrixXd T_inverse;  ///< v x p: T^+ = (T^T T)^-1 T^T
  };

  /// `p` is any position of the mechanism.
  KinematicBlocks(const Equations& eq, const Eigen::VectorXd& p);

  void update(const Eigen::VectorXd& p, const Eigen::VectorXd& w);  ///< T, T^+ and A
  void update_T(const Eigen::VectorXd& p);                          ///< T and T^+ alone
  /// A -= T' T^+ with T' its rate along w, after update(p, w): of a small change of p that is carried along with the
  /// motion, T x, the rate of x is w's change + T^+ A T x.  Of a body that spins it depends on the spin alone.
  void carry_along(const Eigen::VectorXd& p, const Eigen::VectorXd& w);

  const std::vector<Block>& blocks() const { return blocks_; }

  /// Z (m x n_v) = Z_p (m x n_p) T.
  void multiply_T(const Eigen::MatrixXd& Z_p, Eigen::MatrixXd& Z) const;

 private:
  const Equations& eq_;
  std::vector<Block> blocks_;
  int n_p_, n_v_, widest_p_ = 0, widest_v_ = 0;
  Eigen::VectorXd p_step_, w_step_, rate_, rate_step_;
};

}  // namespace flexura::mbs
