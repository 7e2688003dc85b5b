// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "mbs/solver/run/run.hpp"

/// Runs that can be taken up after their process was killed.  What is handed out between two steps is all
/// that the run remembers, its own figures included: the run that goes on from there gives the same rows and
/// the same result as one that was never cut, to the bit, apart from wall times.
namespace flexura::mbs {

struct RunMemory {
  Continuation continuation;  ///< its state as the integrator left it
  StepCounts counts;
  double largest_energy_error = 0.0, peak_position_drift = 0.0, peak_velocity_drift = 0.0;
  double good_step = 0.0;  ///< [s] the longest of the last steps
  double wall_time = 0.0;  ///< [s] until then
  std::vector<RootEvent> events;
};

struct Remembering {
  /// Asked after every step.
  std::function<bool()> wanted;
  /// All rows before continuation.next_row have been given away by now, no other.
  std::function<void(const RunMemory&)> take;
  bool at_the_end = true;  ///< also where the run stops before its end time
};

/// Like run() of run.hpp, and with `from` on from there; rows that were given away before are not given
/// again.
RunResult run(const Equations& eq, const State& start, const Eigen::VectorXd& v_dot,
              const SolverOptions& options, const RunCallbacks& callbacks, const Remembering& remembering);
RunResult run(const Equations& eq, const RunMemory& from, const SolverOptions& options,
              const RunCallbacks& callbacks, const Remembering& remembering);

}  // namespace flexura::mbs
