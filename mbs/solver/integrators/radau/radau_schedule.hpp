// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/algebra/history.hpp"

namespace flexura::mbs {

/// When Newton's method of Radau IIA works with a matrix for each stage (radau_stages.hpp) and when with one for all: where the
/// former is wanted again soon, the next steps begin with it, and where it does not serve it is not tried again for some.
class StageSchedule {
 public:
  StageSchedule();

  /// The step begins with a matrix for each stage.
  bool begins_with_stages() const { return steps_ > 0; }
  /// One matrix did not do: are they to be tried?  `is_at_its_best`: it held all derivatives, taken for this very step.
  bool wants_stages(bool is_at_its_best) const;
  /// What came of one matrix, and of one for each stage.
  void take_plain(bool converged);
  void take_stages(bool converged);
  void count_accepted_step();

  void remember(History& history);

 private:
  // Steps to come that begin with them, or that do without; how many the next time, and steps since then.
  int steps_ = 0, wait_ = 0, run_ = 1, span_, plain_steps_;
  double trouble_rate_ = 0.0;  // failures of Newton's method with one matrix, of some ten attempts
};

}  // namespace flexura::mbs
