// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mbs/model/equations.hpp"

/// The kinematic map p' = T(p) w splits into small blocks (one number for a hinge, four for a ball joint).
/// This class finds the blocks once and then evaluates T and A = d(T(p) w)/dp with as many calls as the
/// largest block is wide.
namespace flexura::mbs {

class KinematicBlocks {
 public:
  struct Block {
    std::vector<int> p, v;           ///< indices of positions and velocities
    Eigen::MatrixXd T, A;            ///< p x v, p x p
    Eigen::MatrixXd E, ET;           ///< (c I - A)^-1 and its product with T, set by invert()
    Eigen::MatrixXd T_inverse, TET;  ///< v x p: (T^T T)^-1 T^T; v x v: T_inverse E T; set by invert()
  };

  /// `p` is any position of the mechanism.
  KinematicBlocks(const Equations& eq, const Eigen::VectorXd& p);

  void update(const Eigen::VectorXd& p, const Eigen::VectorXd& w);  ///< T and A
  void invert(double c);                                            ///< E = (c I - A)^-1 and E T

  const std::vector<Block>& blocks() const { return blocks_; }

  /// Z (m x n_v) = Z_p (m x n_p) E T.
  void multiply_ET(const Eigen::MatrixXd& Z_p, Eigen::MatrixXd& Z) const;
  /// Z (m x n_v) = Z_p (m x n_p) T.
  void multiply_T(const Eigen::MatrixXd& Z_p, Eigen::MatrixXd& Z) const;
  /// Z (m x n_v) = Z_v (m x n_v) T^+ E T, the derivative by v of what depends on p through Z_v = Z_p T alone.
  void multiply_TET(const Eigen::MatrixXd& Z_v, Eigen::MatrixXd& Z) const;
  /// w (n_v) = T^+ y (n_p).
  void apply_T_inverse(ConstVectorRef y, VectorRef w) const;
  /// x (n_p) = E y (n_p); may not be the same vector.
  void apply_E(ConstVectorRef y, VectorRef x) const;
  /// x (n_p) += E T w (n_v).
  void add_ET(ConstVectorRef w, VectorRef x) const;

 private:
  const Equations& eq_;
  std::vector<Block> blocks_;
  int n_p_, n_v_, widest_p_ = 0, widest_v_ = 0;
  Eigen::VectorXd p_step_, w_step_, rate_, rate_step_;
};

}  // namespace flexura::mbs
