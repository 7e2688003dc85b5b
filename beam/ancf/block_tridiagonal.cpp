// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/block_tridiagonal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace flexura::beam::ancf {

BlockTridiagonal::BlockTridiagonal(int n_blocks, int size)
    : n_blocks_(n_blocks), size_(size), data_(static_cast<std::size_t>(3) * n_blocks * size * size, 0.0) {}

void BlockTridiagonal::set_zero() {
  std::fill(data_.begin(), data_.end(), 0.0);
}

void BlockTridiagonal::add_element(int k, const Eigen::Ref<const Eigen::MatrixXd>& element) {
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) block(k + i, k + j) += element.block(size_ * i, size_ * j, size_, size_);
}

void BlockTridiagonal::multiply_add(double factor, const Eigen::Ref<const Eigen::VectorXd>& x,
                                    Eigen::Ref<Eigen::VectorXd> y) const {
  for (int i = 0; i < n_blocks_; ++i)
    for (int j = std::max(0, i - 1); j <= std::min(n_blocks_ - 1, i + 1); ++j)
      y.segment(size_ * i, size_).noalias() += factor * block(i, j).lazyProduct(x.segment(size_ * j, size_));
}

void BlockTridiagonal::append_to(Triplets& triplets, double factor) const {
  for (int i = 0; i < n_blocks_; ++i)
    for (int j = std::max(0, i - 1); j <= std::min(n_blocks_ - 1, i + 1); ++j) {
      const ConstBlock b = block(i, j);
      for (int c = 0; c < size_; ++c)
        for (int r = 0; r < size_; ++r)
          if (b(r, c) != 0.0) triplets.emplace_back(size_ * i + r, size_ * j + c, factor * b(r, c));
    }
}

Eigen::SparseMatrix<double> BlockTridiagonal::to_sparse() const {
  Triplets triplets;
  append_to(triplets);
  Eigen::SparseMatrix<double> out(rows(), rows());
  out.setFromTriplets(triplets.begin(), triplets.end());
  return out;
}

void BlockCholesky::factor(const BlockTridiagonal& A) {
  if (A.block_size() > kMaxBlock)
    throw std::invalid_argument(
        fmt::format("block size {} is above the {} a beam node needs.", A.block_size(), kMaxBlock));
  const int n = A.n_blocks();
  pivots_.resize(n);
  upper_.resize(n);
  SmallMatrix D;
  for (int i = 0; i < n; ++i) {
    D = A.block(i, i);
    if (i > 0) D.noalias() -= A.block(i, i - 1).lazyProduct(upper_[i - 1]);
    pivots_[i].compute(D);
    if (pivots_[i].info() != Eigen::Success)
      throw std::runtime_error(fmt::format("the matrix is not positive definite at node {}.", i));
    if (i + 1 < n) {
      upper_[i] = A.block(i, i + 1);
      pivots_[i].solveInPlace(upper_[i]);
    }
  }
}

void BlockCholesky::solve(Eigen::Ref<Eigen::VectorXd> x) const {
  const int n = static_cast<int>(pivots_.size());
  const int b = n > 0 ? static_cast<int>(pivots_[0].rows()) : 0;
  for (int i = 0; i < n; ++i) {
    auto x_i = x.segment(b * i, b);
    // A_i,i-1 D_i-1^-1 = upper_i-1^T by symmetry, so the forward sweep acts before the pivots divide.
    if (i > 0) x_i.noalias() -= upper_[i - 1].transpose().lazyProduct(x.segment(b * (i - 1), b));
  }
  for (int i = n - 1; i >= 0; --i) {
    auto x_i = x.segment(b * i, b);
    pivots_[i].solveInPlace(x_i);
    if (i + 1 < n) x_i.noalias() -= upper_[i].lazyProduct(x.segment(b * (i + 1), b));
  }
}

}  // namespace flexura::beam::ancf
