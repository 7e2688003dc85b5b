// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <set>

#include "mbs/solver/integrators/integrator.hpp"
#include "mbs/solver/integrators/peak_watch.hpp"
#include "mbs/solver/run/energy.hpp"

/// Steps that leapt over what they should have seen, peaks of forces and switches soon behind one another: they are to be
/// made again, and those that follow are short until nothing is met any more.
namespace flexura::mbs {

class LeapWatch {
 public:
  LeapWatch(const Equations& eq, const SolverOptions& options);

  /// Whether the step is to be made again from where it began, no longer than reach().  `has_history`: the integrator had
  /// taken one since its last start.
  bool over_switches(const StepEnd& end, bool has_history);
  /// Whether the step leapt over a peak of a force; it then ends where that begins.
  bool over_peak(StepEnd& end, Integrator& integrator);
  /// Such a peak is that of the step itself, which is made again.
  bool is_at_beginning(const StepEnd& end) const;
  /// Behind a step that saw all there was.
  void widen();
  /// The longest step that may follow [s]; 0: no bound.
  double reach() const { return reach_; }
  void remember(History& history);

 private:
  PeakWatch peaks_;
  double duration_;  // of the run [s]
  double reach_ = 0.0;
  std::optional<StepEnd> leapt_;  // what a step that was made again had led to
  std::set<int> harmless_;        // switches at which nothing was found that way
  Instant between_;
};

}  // namespace flexura::mbs
