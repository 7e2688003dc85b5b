// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/lanczos_space.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/dense/random_numbers.hpp"

namespace flexura::linalg {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

LanczosSpace::LanczosSpace(const EigenProblem& problem, const VectorStorage& storage, Index block,
                           Index capacity)
    : problem_(problem),
      block_(block),
      capacity_(capacity),
      basis_(problem, storage, capacity),
      random_(20240229 + static_cast<unsigned>(problem.rank)),
      H_(0, 0) {
  add_start(block_);
}

// S M on random vectors joins the newest block.
void LanczosSpace::add_start(Index width) {
  const MatrixXd X = random_numbers(problem_.n, width, random_);
  MatrixXd MX, W, C, R;
  problem_.multiply_M(X, MX);
  problem_.solve(MX, W);
  const Index old = basis_.size();
  basis_.append(std::move(W), C, R);
  const Index added = basis_.size() - old;
  newest_ += added;
  R_.conservativeResize(R_.rows() + added, Eigen::NoChange);  // S of what is there does not meet it
  R_.bottomRows(added).setZero();
  n_starting_ += width;
  n_solves_ += static_cast<int>(width);
  ++n_blocks_;
}

void LanczosSpace::expand() {
  MatrixXd W, C;
  problem_.solve(basis_.multiply_newest_by_M(newest_), W);
  n_solves_ += static_cast<int>(newest_);
  ++n_blocks_;
  const Index old = basis_.size();
  basis_.append(std::move(W), C, R_);
  H_.conservativeResize(old, old);
  H_.rightCols(newest_) = C;
  H_.bottomRows(newest_) = C.transpose();
  applied_ = newest_;
  newest_ = basis_.size() - old;
}

bool LanczosSpace::begin_anew(Index width) {
  const Index old = basis_.size();
  if (old >= problem_.n_free) return false;
  if (width == 0) width = block_;
  if (old + 2 * (newest_ + width) > capacity_) reserve(old + 4 * (newest_ + width));
  add_start(width);
  return basis_.size() > old;
}

void LanczosSpace::reserve(Index capacity) {
  basis_.reserve(capacity);
  capacity_ = capacity;
}

LanczosSpace::RitzPairs LanczosSpace::ritz_pairs() const {
  const DenseEigen eigen = symmetric_eigen(0.5 * (H_ + H_.transpose()));
  const Index n = H_.rows();
  RitzPairs pairs{eigen.values.reverse(), eigen.vectors.rowwise().reverse(), VectorXd::Zero(n)};
  if (R_.rows() > 0)
    for (Index k = 0; k < n; ++k)
      pairs.estimate(k) = (R_ * pairs.Y.col(k).tail(applied_)).norm() / std::abs(pairs.theta(k));
  return pairs;
}

MatrixXd LanczosSpace::vectors(const MatrixXd& Y, const VectorXd& theta) const {
  MatrixXd Phi = times(basis_.vectors(0, size()), Y);
  if (newest_ > 0) {
    MatrixXd tail = R_ * Y.bottomRows(applied_);
    for (Index k = 0; k < tail.cols(); ++k) tail.col(k) /= theta(k);
    add_product(1.0, basis_.vectors(size(), newest_), tail, Phi);
  }
  return Phi;
}

void LanczosSpace::restart(const MatrixXd& Y, const VectorXd& theta) {
  basis_.restart(Y, newest_);
  H_ = theta.asDiagonal();
  if (is_full()) reserve(basis_.size() + 4 * newest_);  // many vectors have joined the newest block
}

void LanczosLooks::plan(Index size, Index known, Index target, double too_large) {
  const double side = static_cast<double>(size), since = side - static_cast<double>(looked_at_);
  const double gained = static_cast<double>(known - known_then_);
  const double least = std::clamp(8.0 * side * side / n_rows_, block_, std::max(side / 8.0, block_));
  double needed = gained > 0.0 ? static_cast<double>(target - known) * since / gained : 0.0;
  // Errors fall by a factor with each block, once they fall at all.
  if (too_large > 1.0 && too_large < 0.1 * too_large_then_)
    needed = std::min(gained > 0.0 ? needed : side,
                      since * std::log(too_large) / std::log(too_large_then_ / too_large));
  next_ = size + static_cast<Index>(std::clamp(needed, least, std::max(least, side / 4.0)));
  looked_at_ = size;
  known_then_ = known;
  too_large_then_ = too_large;
}

}  // namespace flexura::linalg
