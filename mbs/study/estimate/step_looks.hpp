// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

namespace flexura::study {

/// Which steps of a run to look at beside its rows: those that are much shorter than the run's steps were so far, as
/// where bodies strike one another.  Not all of a run that strikes all the time: some kMost, as the run goes on, so
/// that what happens late in it and seldom is seen.
class StepLooks {
 public:
  /// span [s] of the run.
  explicit StepLooks(double span) : span_(span) {}

  bool wants(double begin, double end) {
    const double h = end - begin;
    // By time: a few short steps hardly count.
    const double usual = time_ > 0.0 ? weighted_ / time_ : 0.0;
    time_ += h;
    weighted_ += h * h;
    left_ = std::min(kAtOnce, left_ + (kMost - kAtOnce) * h / span_);
    if (!(h < kShort * usual) || left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }

 private:
  static constexpr double kShort = 0.25, kAtOnce = 100.0, kMost = 300.0;
  double span_, time_ = 0.0, weighted_ = 0.0, left_ = kAtOnce;
};

}  // namespace flexura::study
