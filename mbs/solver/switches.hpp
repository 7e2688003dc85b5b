// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "mbs/model/equations.hpp"
#include "mbs/solver/history.hpp"

/// Locates inside a step where a switching function falls below 0, on the integrator's polynomial and to the
/// round-off of the time: the Illinois form of regula falsi.
///
/// Functions are positive while their switch is in the right position (Equations::roots), so that one that
/// begins at 0, as for a ball put down on the floor, is judged by where it goes from there.
namespace flexura::mbs {

class SwitchFinder {
 public:
  explicit SwitchFinder(const Equations& eq);

  /// Forgets the past: call at every (re)start.
  void start(const State& s);

  /// Looks at the step [t_begin, t_end] whose states `state_at` gives.  Returns true when a function falls
  /// below 0: t_end is then moved to the first such time (just behind it) and `which` lists the functions.
  bool search(double t_begin, double& t_end, const std::function<const State&(double)>& state_at,
              std::vector<int>& which);

  void remember(History& history) { history(low_); }

 private:
  bool any_negative(const Eigen::VectorXd& values) const { return (values.array() < 0.0).any(); }

  const Equations& eq_;
  int n_root_;
  std::unique_ptr<Equations::Scratch> scratch_;
  Eigen::VectorXd low_, high_, middle_;  // at both ends of the interval and between
};

}  // namespace flexura::mbs
