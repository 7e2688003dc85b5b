// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/kinematic_blocks.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

namespace flexura::mbs {

namespace {

constexpr double kStep = 1e-7;  // T is at most quadratic in p: errors of 1e-7 for a Newton matrix

}  // namespace

KinematicBlocks::KinematicBlocks(const Equations& eq, const Eigen::VectorXd& p) : eq_(eq) {
  const Sizes n = eq.sizes();
  n_p_ = n.n_p;
  n_v_ = n.n_v;
  p_step_.resize(n_p_);
  rate_.resize(n_p_);
  rate_step_.resize(n_p_);
  w_step_ = Eigen::VectorXd::Zero(n_v_);

  // A place and a velocity without accidental zeros show the pattern.
  Eigen::VectorXd place = p, w(n_v_);
  for (int i = 0; i < n_p_; ++i) place(i) += 0.13 * std::cos(1.7 * i + 0.3);
  for (int j = 0; j < n_v_; ++j) w(j) = 1.0 + 0.4 * std::sin(2.3 * j);

  std::vector<int> parent(n_p_), owner(n_v_, -1);
  std::iota(parent.begin(), parent.end(), 0);
  std::function<int(int)> root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (int j = 0; j < n_v_; ++j) {
    w_step_(j) = 1.0;
    eq.kinematic(place, w_step_, rate_);
    w_step_(j) = 0.0;
    for (int i = 0; i < n_p_; ++i) {
      if (rate_(i) == 0.0) continue;
      if (owner[j] < 0) owner[j] = i;
      parent[root(i)] = root(owner[j]);
    }
  }
  eq.kinematic(place, w, rate_);
  for (int j = 0; j < n_p_; ++j) {
    p_step_ = place;
    p_step_(j) += kStep;
    eq.kinematic(p_step_, w, rate_step_);
    for (int i = 0; i < n_p_; ++i)
      if (rate_step_(i) != rate_(i)) parent[root(i)] = root(j);
  }
  std::vector<int> block_of(n_p_, -1);
  for (int i = 0; i < n_p_; ++i) {
    int& b = block_of[root(i)];
    if (b < 0) {
      b = static_cast<int>(blocks_.size());
      blocks_.emplace_back();
    }
    blocks_[b].p.push_back(i);
  }
  for (int j = 0; j < n_v_; ++j)
    if (owner[j] >= 0) blocks_[block_of[root(owner[j])]].v.push_back(j);
  for (Block& b : blocks_) {
    const auto n_bp = static_cast<Eigen::Index>(b.p.size()), n_bv = static_cast<Eigen::Index>(b.v.size());
    b.T.setZero(n_bp, n_bv);
    b.A.setZero(n_bp, n_bp);
    b.T_inverse.setZero(n_bv, n_bp);
    widest_p_ = std::max(widest_p_, static_cast<int>(n_bp));
    widest_v_ = std::max(widest_v_, static_cast<int>(n_bv));
  }
}

void KinematicBlocks::update_T(const Eigen::VectorXd& p) {
  for (int k = 0; k < widest_v_; ++k) {
    w_step_.setZero();
    for (const Block& b : blocks_)
      if (k < static_cast<int>(b.v.size())) w_step_(b.v[k]) = 1.0;
    eq_.kinematic(p, w_step_, rate_);
    for (Block& b : blocks_)
      if (k < static_cast<int>(b.v.size()))
        for (std::size_t i = 0; i < b.p.size(); ++i) b.T(i, k) = rate_(b.p[i]);
  }
  w_step_.setZero();
  for (Block& b : blocks_) {
    if (b.v.empty()) continue;
    // No block is wider than a body's coordinates: these stay on the stack.
    using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 8, 8>;
    const Small gram = b.T.transpose() * b.T;
    b.T_inverse.noalias() = Small(gram.inverse()) * b.T.transpose();
  }
}

void KinematicBlocks::update(const Eigen::VectorXd& p, const Eigen::VectorXd& w) {
  update_T(p);
  if (widest_p_ <= 1) return;  // a single number turns or slides: T does not depend on it
  eq_.kinematic(p, w, rate_);
  p_step_ = p;
  for (int k = 0; k < widest_p_; ++k) {
    for (const Block& b : blocks_)
      if (k < static_cast<int>(b.p.size())) p_step_(b.p[k]) = p(b.p[k]) + kStep;
    eq_.kinematic(p_step_, w, rate_step_);
    for (Block& b : blocks_)
      if (k < static_cast<int>(b.p.size())) {
        for (std::size_t i = 0; i < b.p.size(); ++i) b.A(i, k) = (rate_step_(b.p[i]) - rate_(b.p[i])) / kStep;
        p_step_(b.p[k]) = p(b.p[k]);
      }
  }
}

void KinematicBlocks::carry_along(const Eigen::VectorXd& p, const Eigen::VectorXd& w) {
  if (widest_p_ <= 1) return;
  eq_.kinematic(p, w, rate_);
  // T is quadratic in p at most: central differences are exact but for round-off.
  constexpr double kAlong = 1e-4;
  p_step_ = p + kAlong * rate_;
  const Eigen::VectorXd before = p - kAlong * rate_;
  for (int k = 0; k < widest_v_; ++k) {
    w_step_.setZero();
    for (const Block& b : blocks_)
      if (k < static_cast<int>(b.v.size())) w_step_(b.v[k]) = 1.0;
    eq_.kinematic(p_step_, w_step_, rate_step_);
    eq_.kinematic(before, w_step_, rate_);
    for (Block& b : blocks_)
      if (k < static_cast<int>(b.v.size()) && b.p.size() > 1)
        for (std::size_t i = 0; i < b.p.size(); ++i)
          b.A.row(static_cast<Eigen::Index>(i)) -=
              (rate_step_(b.p[i]) - rate_(b.p[i])) / (2.0 * kAlong) * b.T_inverse.row(k);
  }
  w_step_.setZero();
}

void KinematicBlocks::multiply_T(const Eigen::MatrixXd& Z_p, Eigen::MatrixXd& Z) const {
  Z.setZero(Z_p.rows(), n_v_);
  for (const Block& b : blocks_)
    for (std::size_t j = 0; j < b.v.size(); ++j)
      for (std::size_t i = 0; i < b.p.size(); ++i) Z.col(b.v[j]) += b.T(i, j) * Z_p.col(b.p[i]);
}

}  // namespace flexura::mbs
