// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/span_path.hpp"

#include <algorithm>
#include <vector>

namespace flexura::study {
namespace {

using Eigen::VectorXd;

// T is quadratic in p at most: its change along p' by differences is exact but for round-off.
constexpr double kStep = 1e-4;

}  // namespace

SpanPath::SpanPath(const mbs::Equations& eq, const VectorXd& p)
    : eq_(eq), n_(eq.sizes()), kinematics_(eq, p) {
  for (VectorXd* x : {&step_, &up_, &down_, &rate_, &rate2_}) x->setZero(n_.n_p);
  for (VectorXd& x : p_) x.setZero(n_.n_p);
  for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks())
    has_turns_ = has_turns_ || block.p.size() > 1;
}

void SpanPath::lay(const mbs::State& begin, const VectorXd& v_dot_begin, const mbs::Instant& end) {
  t_ = begin.t;
  h_ = end.state.t - begin.t;
  rates(begin, v_dot_begin, p_.data());
  rates(end.state, end.v_dot, p_.data() + 3);
  // A quaternion and its opposite are one.
  for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks()) {
    if (block.p.size() < 2) continue;
    double sum = 0.0;
    for (const int i : block.p) sum += p_[0](i) * p_[3](i);
    if (sum < 0.0)
      for (const int i : block.p)
        for (std::size_t k = 3; k < 6; ++k) p_[k](i) *= -1.0;
  }
  // What differs from even motion: round-off of p itself, over h^2, would be accelerations of 1e10 rad/s^2 in the first
  // steps of 1e-13 s.
  p_[3] -= p_[0];
  p_[3] -= p_[1];
  p_[4] -= p_[1];
}

// p, h p' and h^2 p'' of a state with accelerations v_dot.
void SpanPath::rates(const mbs::State& s, const VectorXd& v_dot, VectorXd* p) {
  p[0] = s.p;
  eq_.kinematic(s.p, s.v, rate_);
  eq_.kinematic(s.p, v_dot, p[2]);
  if (has_turns_) {
    up_ = s.p + kStep * rate_;
    eq_.kinematic(up_, s.v, rate2_);
    p[2] += rate2_ / (2.0 * kStep);
    up_ = s.p - kStep * rate_;
    eq_.kinematic(up_, s.v, rate2_);
    p[2] -= rate2_ / (2.0 * kStep);
  }
  p[1] = h_ * rate_;
  p[2] *= h_ * h_;
}

void SpanPath::to_velocities(const VectorXd& p, VectorXd& v) const {
  for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks())
    for (std::size_t i = 0; i < block.v.size(); ++i) {
      double sum = 0.0;
      for (std::size_t j = 0; j < block.p.size(); ++j)
        sum += block.T_inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * p(block.p[j]);
      v(block.v[i]) = sum;
    }
}

void SpanPath::at(double x, mbs::State& s, VectorXd& v_dot) {
  const double x2 = x * x, x3 = x2 * x, x4 = x3 * x, x5 = x4 * x;
  const double value[4] = {0.5 * x2 - 1.5 * x3 + 1.5 * x4 - 0.5 * x5, 10 * x3 - 15 * x4 + 6 * x5,
                           -4 * x3 + 7 * x4 - 3 * x5, 0.5 * x3 - x4 + 0.5 * x5};
  const double slope[4] = {x - 4.5 * x2 + 6 * x3 - 2.5 * x4, 30 * x2 - 60 * x3 + 30 * x4,
                           -12 * x2 + 28 * x3 - 15 * x4, 1.5 * x2 - 4 * x3 + 2.5 * x4};
  const double bend[4] = {1 - 9 * x + 18 * x2 - 10 * x3, 60 * x - 180 * x2 + 120 * x3,
                          -24 * x + 84 * x2 - 60 * x3, 3 * x - 12 * x2 + 10 * x3};
  s.p = p_[0] + x * p_[1];
  rate_ = p_[1];
  rate2_.setZero();
  for (std::size_t k = 0; k < 4; ++k) {
    s.p += value[k] * p_[k + 2];
    rate_ += slope[k] * p_[k + 2];
    rate2_ += bend[k] * p_[k + 2];
  }
  rate_ /= h_;
  rate2_ /= h_ * h_;
  s.v.resize(n_.n_v);
  v_dot.resize(n_.n_v);
  kinematics_.update_T(s.p);
  to_velocities(rate_, s.v);
  if (has_turns_) {
    step_ = s.p + kStep * rate_;
    eq_.kinematic(step_, s.v, up_);
    step_ = s.p - kStep * rate_;
    eq_.kinematic(step_, s.v, down_);
    rate2_ -= (up_ - down_) / (2.0 * kStep);
  }
  to_velocities(rate2_, v_dot);
  if (has_turns_) follow_norms(s, v_dot);
}

// Of a quaternion the path leaves the norm, p' = T v + n with T^T n = 0, and v = T^+ p' changes by (T^T T)^-1 T'^T n more.
void SpanPath::follow_norms(const mbs::State& s, VectorXd& v_dot) {
  eq_.kinematic(s.p, s.v, up_);
  down_ = rate_ - up_;  // n
  v_step_.setZero(n_.n_v);
  std::size_t widest = 0;
  for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks())
    if (block.p.size() > 1) widest = std::max(widest, block.v.size());
  // T is linear in a quaternion: its rate is T of the quaternion's rate.
  std::vector<VectorXd> sums(kinematics_.blocks().size());
  for (std::size_t k = 0; k < widest; ++k) {
    v_step_.setZero();
    for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks())
      if (k < block.v.size()) v_step_(block.v[k]) = 1.0;
    eq_.kinematic(rate_, v_step_, up_);
    for (std::size_t b = 0; b < sums.size(); ++b) {
      const mbs::KinematicBlocks::Block& block = kinematics_.blocks()[b];
      if (block.p.size() < 2 || k >= block.v.size()) continue;
      if (sums[b].size() == 0) sums[b].setZero(static_cast<Eigen::Index>(block.v.size()));
      for (const int i : block.p) sums[b](static_cast<Eigen::Index>(k)) += up_(i) * down_(i);
    }
  }
  for (std::size_t b = 0; b < sums.size(); ++b) {
    if (sums[b].size() == 0) continue;
    const mbs::KinematicBlocks::Block& block = kinematics_.blocks()[b];
    const VectorXd more = block.T_inverse * (block.T_inverse.transpose() * sums[b]);
    for (std::size_t k = 0; k < block.v.size(); ++k) v_dot(block.v[k]) += more(static_cast<Eigen::Index>(k));
  }
}

void SpanPath::beside(const mbs::State& s, VectorXd& dp, VectorXd& dv) {
  dp.setZero(n_.n_p);
  dv.setZero(n_.n_v);
  if (!(h_ > 0.0) || s.t < t_) return;
  at(std::min((s.t - t_) / h_, 1.0), s_, v_dot_);
  dp = s.p - s_.p;
  for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks()) {
    if (block.p.size() < 2) continue;
    double sum = 0.0;
    for (const int i : block.p) sum += s.p(i) * s_.p(i);
    if (sum < 0.0)
      for (const int i : block.p) dp(i) = s.p(i) + s_.p(i);
  }
  dv = s.v - s_.v;
}

}  // namespace flexura::study
