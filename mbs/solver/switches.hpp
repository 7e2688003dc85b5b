// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "mbs/model/equations.hpp"

/// Locates sign changes of the switching functions inside a step, for integrators without a root finder of
/// their own: the Illinois form of regula falsi on the integrator's polynomial, to the round-off of the time.
namespace flexura::mbs {

class SwitchFinder {
 public:
  explicit SwitchFinder(const Equations& eq);

  /// Forgets the past: call at every (re)start.  Functions that are 0 there get their sign just after it.
  void start(const State& s);

  /// Looks at the step [t_begin, t_end] whose states `state_at` gives.  Returns true when a function changes
  /// sign: t_end is then moved to the first such time (just behind it) and `which` lists the functions.
  bool search(double t_begin, double& t_end, const std::function<const State&(double)>& state_at,
              std::vector<int>& which);

 private:
  void evaluate(const State& s, Eigen::VectorXd& values);

  const Equations& eq_;
  int n_root_;
  std::unique_ptr<Equations::Scratch> scratch_;
  Eigen::VectorXd low_, high_, middle_;
};

}  // namespace flexura::mbs
