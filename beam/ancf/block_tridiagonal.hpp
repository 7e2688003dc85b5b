// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <vector>

/// Matrices of a chain of two-node elements: square blocks on the diagonal and beside it, nothing else.
namespace flexura::beam::ancf {

using Triplets = std::vector<Eigen::Triplet<double>>;

class BlockTridiagonal {
 public:
  using Block = Eigen::Map<Eigen::MatrixXd>;
  using ConstBlock = Eigen::Map<const Eigen::MatrixXd>;

  BlockTridiagonal() = default;
  /// n_blocks x n_blocks blocks of size x size, all zero.
  BlockTridiagonal(int n_blocks, int size);

  int n_blocks() const { return n_blocks_; }
  int block_size() const { return size_; }
  int rows() const { return n_blocks_ * size_; }

  void set_zero();
  /// Block (i, j), |i - j| <= 1.
  Block block(int i, int j) { return {data_.data() + offset(i, j), size_, size_}; }
  ConstBlock block(int i, int j) const { return {data_.data() + offset(i, j), size_, size_}; }

  /// Adds the matrix of the element between blocks k and k + 1 (2 size x 2 size).
  void add_element(int k, const Eigen::Ref<const Eigen::MatrixXd>& element);

  /// y += factor * (this) x.
  void multiply_add(double factor, const Eigen::Ref<const Eigen::VectorXd>& x,
                    Eigen::Ref<Eigen::VectorXd> y) const;

  /// Appends factor * (this), non-zero entries only.
  void append_to(Triplets& triplets, double factor = 1.0) const;
  Eigen::SparseMatrix<double> to_sparse() const;

 private:
  int offset(int i, int j) const { return (3 * i + 1 + j - i) * size_ * size_; }

  int n_blocks_ = 0, size_ = 0;
  std::vector<double> data_;  // row of blocks after row of blocks: (i, i-1), (i, i), (i, i+1)
};

/// Cholesky factor of a symmetric positive definite BlockTridiagonal in O(n_blocks size^3):
/// D_i = A_ii - A_i,i-1 D_i-1^-1 A_i-1,i.  factor() after the first and solve() do not allocate.
class BlockCholesky {
 public:
  /// Largest block: a node of the fully parametrised beam.
  static constexpr int kMaxBlock = 12;

  /// Throws std::runtime_error naming the block whose pivot is not positive definite, std::invalid_argument
  /// for a block size above kMaxBlock.
  void factor(const BlockTridiagonal& A);
  void solve(Eigen::Ref<Eigen::VectorXd> x) const;

 private:
  using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxBlock, kMaxBlock>;
  std::vector<Eigen::LLT<SmallMatrix>> pivots_;
  std::vector<SmallMatrix> upper_;  // D_i^-1 A_i,i+1
};

}  // namespace flexura::beam::ancf
