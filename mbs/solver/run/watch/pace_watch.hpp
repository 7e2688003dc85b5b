// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/accuracy/options.hpp"

/// Tells steps that creep, so that the run would never end, from steps that are short for a while.
///
/// A mechanism that locks, a contact that grinds, a spring stiffer than numbers can tell: a method may go on there
/// for ever with steps of round-off, each of which is right.  Steps are counted in windows of 2000; one creeps where
/// the rest of the run would need more than 1e9 of its mean step.  What vibrates away gets longer steps meanwhile,
/// and what is hit is left in less time: so steps are called endless only after some windows in a row of which none
/// had a mean step twice that of the first.
namespace flexura::mbs {

class PaceWatch {
 public:
  /// Steps that would be needed and are too many; hours of the smallest mechanism.
  static constexpr double kMostSteps = 1e9;

  explicit PaceWatch(const SolverOptions& options) : options_(options), t_window_(options.start_time) {}

  /// A step ended at t.  True at the end of every window that creeps as those before it did.
  bool step(double t);
  /// Windows in a row that crept.
  int windows() const { return windows_; }
  double mean_step() const { return mean_step_; }  ///< of the last window [s]
  double steps_left(double t) const { return (options_.end_time - t) / mean_step_; }
  /// Another method goes on at t.
  void change(double t);

 private:
  SolverOptions options_;
  long steps_ = 0;
  double t_window_, mean_step_ = 0.0, first_ = 0.0;  // first_: mean step of the first of the windows
  int windows_ = 0;
};

}  // namespace flexura::mbs
