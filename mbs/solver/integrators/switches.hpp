// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/algebra/history.hpp"
#include "mbs/solver/integrators/integrator.hpp"

/// Locates inside a step where a switching function falls below 0, on the integrator's polynomial and to the
/// round-off of the time: the Illinois form of regula falsi.
///
/// Between the ends of a step the conditions of formulas are looked at too: at three points, and at the bottom
/// of the parabola through three neighbours where that lies below 0.  Other switches (contacts: small things that fly past
/// each other) are where they come towards 0 so fast that they might reach it within the step: between neighbours of the
/// least of these points down to the bottom, where a distance has a sharp bend.
///
/// Functions are positive while their switch is in the right position (Equations::roots), so that one that
/// begins at 0, as for a ball put down on the floor, is judged by where it goes from there.
namespace flexura::mbs {

class SwitchFinder {
 public:
  explicit SwitchFinder(const Equations& eq);

  /// Puts the state at t within the last step into `s`, of the mechanism's sizes, from the step's polynomial.
  using StateAt = std::function<void(double t, State& s)>;

  /// Forgets the past: call at every (re)start.
  void start(const State& s);

  /// Looks at the step that ends with `end`.  Where a function falls below 0, t_end is moved to the first
  /// such time (just behind it) and `roots` lists the functions.
  void search(StepEnd& end, const StateAt& state_at);

  /// `s` is the state of the last start.
  void remember(History& history, const State& s);

 private:
  using Evaluate = std::function<void(double t, Eigen::VectorXd& values)>;
  double first_dip(double t_begin, double t_end, const Evaluate& evaluate);
  bool may_dip(int k, double h) const;
  double dip_of_approach(double t_begin, double t_end, const Evaluate& evaluate);
  double bottom(int k, double a, double b, double steepest, const Evaluate& evaluate);
  bool any_negative(const Eigen::VectorXd& values) const { return (values.array() < 0.0).any(); }

  const Equations& eq_;
  int n_root_;
  std::vector<int> conditions_, others_;  // of formulas; the rest
  Eigen::VectorXd before_;                // low_ of the last step
  double h_before_ = 0.0;                 // its length; 0: there was none
  std::array<Eigen::VectorXd, 3> between_;
  std::unique_ptr<Equations::Scratch> scratch_;
  State found_;
  Eigen::VectorXd low_, high_, middle_;  // at both ends of the interval and between
};

}  // namespace flexura::mbs
