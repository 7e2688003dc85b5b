// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mbs/solver/algebra/kinematic_blocks.hpp"

/// E = (c I - A)^-1, block by block, with the T, T^+ and A that KinematicBlocks::update() found: what takes
/// the positions out of Newton's method for p' = T(p) w.  Scalar is double or std::complex<double>.
namespace flexura::mbs {

template <class Scalar>
class KinematicInverse {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  void compute(const KinematicBlocks& blocks, Scalar c);

  /// Z (m x n_v) = Z_p (m x n_p) E T.
  void multiply_ET(const Eigen::MatrixXd& Z_p, Matrix& Z) const;
  /// Z (m x n_v) = Z_v (m x n_v) T^+ E T, the derivative by v of what depends on p through Z_v = Z_p T alone.
  void multiply_TET(const Eigen::MatrixXd& Z_v, Matrix& Z) const;
  /// add(i, j, value) for every entry of E T (n_p x n_v) and of T^+ E T (n_v x n_v).
  template <class Add>
  void entries_of_ET(Add&& add) const {
    for (std::size_t k = 0; k < inverse_.size(); ++k) {
      const KinematicBlocks::Block& b = blocks_->blocks()[k];
      for (std::size_t j = 0; j < b.v.size(); ++j)
        for (std::size_t i = 0; i < b.p.size(); ++i) add(b.p[i], b.v[j], inverse_[k].ET(i, j));
    }
  }
  template <class Add>
  void entries_of_TET(Add&& add) const {
    for (std::size_t k = 0; k < inverse_.size(); ++k) {
      const std::vector<int>& v = blocks_->blocks()[k].v;
      for (std::size_t j = 0; j < v.size(); ++j)
        for (std::size_t i = 0; i < v.size(); ++i) add(v[i], v[j], inverse_[k].TET(i, j));
    }
  }
  /// x (n_p) = E y (n_p); may not be the same vector.
  void apply_E(const Vector& y, Vector& x) const;
  /// x (n_p) += E T w (n_v).
  void add_ET(const Vector& w, Vector& x) const;
  /// w (n_v) = T^+ y (n_p).
  void apply_T_inverse(const Vector& y, Vector& w) const;

 private:
  struct Block {
    Matrix E, ET, TET;  ///< p x p, p x v, v x v: T^+ E T
  };
  const KinematicBlocks* blocks_ = nullptr;
  std::vector<Block> inverse_;
  int n_v_ = 0;
};

}  // namespace flexura::mbs
