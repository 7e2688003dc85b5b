// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/statics/following_states.hpp"

#include <algorithm>
#include <cmath>

namespace flexura::mbs {

using Eigen::Index;
using Eigen::VectorXd;

FollowingStates::FollowingStates(const Equations& eq)
    : eq_(eq),
      n_(eq.sizes()),
      scratch_(eq.make_scratch()),
      size_v_(n_.n_v),
      r_(n_.n_v),
      c_rate_(n_.n_dyn),
      b_(n_.n_alg) {
  for (int i = 0; i < n_.n_v; ++i) size_v_(i) = eq.velocity_scale(i);
}

void FollowingStates::find(const State& s, const Tangents& t, const Eigen::MatrixXd& K,
                           const VectorXd& c_rate, const VectorXd& d_before) {
  which_.clear();
  const auto is_zero = [](const Eigen::MatrixXd& X, Index row) {
    return X.size() == 0 || X.row(row).isZero(0.0);
  };
  for (int k = 0; k < n_.n_dyn; ++k) {
    const int row = n_.n_v + k;
    if (c_rate(k) == 0.0 && is_zero(K, row) && is_zero(t.z_c, row) && is_zero(t.z_a, row) &&
        is_zero(t.c_v_dot, k) && is_zero(t.c_lambda, k))
      which_.push_back(k);
  }
  B_.resize(static_cast<Index>(which_.size()), n_.n_v);
  for (std::size_t i = 0; i < which_.size(); ++i)
    B_.row(static_cast<Index>(i)) = t.z_v.row(n_.n_v + which_[i]);
  if (which_.empty() || d_before.isZero(0.0)) return;
  const VectorXd one_sided = rate_along(s, d_before)(which_), w = d_before.cwiseQuotient(size_v_.cwiseAbs2());
  B_ += (one_sided - B_ * d_before) * w.transpose() / w.dot(d_before);
}

void FollowingStates::begin_step(const State& s, const VectorXd& d) {
  if (which_.empty()) return;
  constexpr double kMore = 1e-3;  // the rates are linear in c, or nearly so
  slope_ = rate_along(s, d)(which_);
  State loaded = s;
  VectorXd more(slope_.size());
  for (Index i = 0; i < more.size(); ++i) {
    double& c = loaded.c(which_[static_cast<std::size_t>(i)]);
    more(i) = kMore * std::max(std::abs(c), std::abs(slope_(i)));
    c += more(i);
  }
  const VectorXd then = rate_along(std::move(loaded), d)(which_);
  decay_ = (more.array() > 0.0).select((slope_ - then).cwiseQuotient(more), 0.0).cwiseMax(0.0);
}

void FollowingStates::move(double part, VectorXd& c) const {
  for (std::size_t i = 0; i < which_.size(); ++i) {
    const double a = slope_(static_cast<Index>(i)), b = decay_(static_cast<Index>(i));
    c(which_[i]) += b > 0.0 ? -a * std::expm1(-b * part) / b : a * part;
  }
}

// c' at a crawl along d, times what is missing to d in a unit of time.
VectorXd FollowingStates::rate_along(State s, const VectorXd& d) {
  constexpr double kCrawl = 1e-6;  // typical sizes per second
  const double size = d.cwiseQuotient(size_v_).lpNorm<Eigen::Infinity>();
  if (!(size > 0.0)) return VectorXd::Zero(n_.n_dyn);
  s.v = kCrawl / size * d;
  eq_.momentum(s, VectorXd::Zero(n_.n_v), *scratch_, r_, c_rate_, b_);
  return size / kCrawl * c_rate_;
}

}  // namespace flexura::mbs
