// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>

#include "mbs/solver/algebra/history.hpp"
#include "mbs/solver/run/energy.hpp"

/// How long the motion allows steps to be away from trouble, and where the last long ones began: from there explicit steps
/// may lead across a singular position that the integrator only creeps into.
namespace flexura::mbs {

class LongSteps {
 public:
  /// A step of the duration h [s] from this state; `keeps` where its beginning may be wanted.
  void take(double h, bool keeps, const State& s, const Eigen::VectorXd& v_dot);
  /// The longest of the last ones [s].
  double longest() const { return longest_; }
  void set_longest(double h) { longest_ = h; }
  /// What is behind an event is no way to what was before it.
  void forget_beginnings() { n_ = 0; }
  std::size_t n_beginnings() const { return n_; }
  /// The k-th before the present state, from 1 on.
  const Instant& beginning(std::size_t k) const { return ring_[(next_ + ring_.size() - k) % ring_.size()]; }
  /// Beginnings alone.
  void remember(History& history, const Sizes& sizes);

 private:
  double longest_ = 0.0;
  std::array<Instant, 3> ring_;
  std::size_t n_ = 0, next_ = 0;
};

}  // namespace flexura::mbs
