// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/watch/pace_watch.hpp"

namespace flexura::mbs {

namespace {

constexpr long kWindow = 2000;
// Steps of the length that the user asked for are no trouble of the method's.
constexpr double kAsked = 0.1;

}  // namespace

bool PaceWatch::step(double t) {
  if (++steps_ < kWindow) return false;
  mean_step_ = (t - t_window_) / kWindow;
  steps_ = 0;
  t_window_ = t;
  const bool is_asked_for =
      (options_.max_step > 0.0 || options_.fixed_step > 0.0) && mean_step_ > kAsked * options_.longest_step();
  if (is_asked_for || options_.end_time - t <= kMostSteps * mean_step_) {
    windows_ = 0;
    return false;
  }
  if (windows_ == 0 || mean_step_ > 2.0 * first_) {
    windows_ = 0;
    first_ = mean_step_;
  }
  return ++windows_ > 1;
}

void PaceWatch::change(double t) {
  steps_ = 0;
  windows_ = 0;
  t_window_ = t;
}

}  // namespace flexura::mbs
