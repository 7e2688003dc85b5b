// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/watch/long_steps.hpp"

#include <algorithm>

#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {

void LongSteps::take(double h, bool keeps, const State& s, const Eigen::VectorXd& v_dot) {
  constexpr double kFades = 0.99, kIsLong = 0.1;
  longest_ = std::max(h, kFades * longest_);
  if (!keeps || !(h > kIsLong * longest_)) return;
  ring_[next_].state = s;
  ring_[next_].v_dot = v_dot;
  next_ = (next_ + 1) % ring_.size();
  n_ = std::min(n_ + 1, ring_.size());
}

void LongSteps::remember(History& history, const Sizes& sizes) {
  for (Instant& one : ring_) {
    history(one.state);
    history(one.v_dot);
  }
  long n = static_cast<long>(n_), next = static_cast<long>(next_);
  history(n);
  history(next);
  if (!history.reads()) return;
  const auto all = static_cast<long>(ring_.size());
  require_between(n, 0, all);
  require_between(next, 0, all - 1);
  n_ = static_cast<std::size_t>(n);
  next_ = static_cast<std::size_t>(next);
  for (std::size_t k = 1; k <= n_; ++k) {
    require_sizes(beginning(k).state, sizes);
    require_size(beginning(k).v_dot.size(), sizes.n_v);
  }
}

}  // namespace flexura::mbs
