// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "mbs/solver/integrators/integrator.hpp"
#include "mbs/solver/run/energy.hpp"

/// One dynamic run with any integrator: rows at a fixed rate, switches, energy book, constraint drift, clean
/// stops.  Rows, switches and the end are brought onto the constraints to round-off (LoopCloser), the steps
/// between them are not.
namespace flexura::mbs {

struct RunCallbacks {
  /// Called at start_time, at every output time and at the end.
  std::function<void(const State&, const Eigen::VectorXd& v_dot, const EnergyAccount&)> row;
  /// Called in turn with `row`, with states as good as its own, at the times `look_at` [s] (in their order, behind
  /// start_time) and at the end of steps that `wants_look` asks for; a row at the same time is left to `row`.
  std::function<void(const State&, const Eigen::VectorXd& v_dot)> look;
  std::vector<double> look_at;
  /// Of a step between these times.  By the thread that integrates.
  std::function<bool(double begin, double end)> wants_look;
  /// Rows are made and `row` is called by a second thread, some steps behind: it then shares nothing with the
  /// other two.  The numbers are the same to the bit; when run() returns, all rows are there.
  bool rows_beside = false;
  /// Called, before the rows within it, for every step that a motion was integrated by: what the integrator's own
  /// polynomial says at its begin and at EnergyBook::node_times(), the last of which is its end.  By the thread that
  /// calls `row`.
  std::function<void(const Instant& begin, const std::array<Instant, 3>& nodes)> step;
  /// Called where the integrator starts, and starts anew behind an event: from this state with these accelerations.
  /// Never beside `step` or `row`.
  std::function<void(const State&, const Eigen::VectorXd& v_dot, const IntegratorKind&)> restart;
  /// Called after every step with the time reached and the fraction done.
  std::function<void(double t, double fraction)> progress;
  /// True asks for a clean stop after the present step (Ctrl-C).
  std::function<bool()> stop_wanted;
};

struct RootEvent {
  double t = 0.0;
  int which = 0;
  bool jumped = false;  ///< velocities changed
};

/// What a later run needs to go on where this one ended, as if it had not been cut: the same rows at the same
/// times, to the bit when the options are the same but for stop_time.
struct Continuation {
  std::string method;
  State state;
  Eigen::VectorXd v_dot;
  EnergyAccount energy;
  long next_row = 0;
  std::vector<double> history;  ///< of the integrator
};

struct RunResult {
  bool complete = false;
  std::string stopped_because;   ///< empty when complete
  bool stopped_as_told = false;  ///< at stop_time
  State state;                   ///< at the last time reached
  Eigen::VectorXd v_dot;
  StepCounts counts;
  EnergyAccount energy;
  double largest_energy_error = 0.0;  ///< largest |EnergyAccount::error| at the ends of steps [J]
  double peak_position_drift = 0.0;   ///< largest |g| at rows, switches and the end, holonomic rows
  double peak_velocity_drift = 0.0;   ///< largest |G v + g_t|
  double wall_time = 0.0;             ///< s
  std::vector<RootEvent> events;
  std::string method;                       ///< the integrator that took the last step
  std::vector<std::string> method_changes;  ///< one sentence for each, where the method was left open
  std::string
      method_hint;  ///< where another method would have been much faster, else empty (method_watch.hpp)
  std::string
      near_rank_loss;  ///< where rows came so near to depending on each other that forces suffer, else empty
  /// By what speeds, accelerations and reactions of rows, but for those that near_rank_loss tells of, may be off by what their
  /// loops are open by, in parts of themselves.
  double doubt_of_rows = 0.0;
  /// By what reactions that the energy account integrates may be off, in parts of themselves: next to dead points.
  double doubt_of_energy = 0.0;
  long time_events = 0;  ///< known beforehand: jumps of functions of time
  Continuation continuation;
};

/// Runs from the consistent state `start` (see assemble.hpp) to options.end_time.  What goes wrong on the way
/// ends the run cleanly: the result then holds the last state and the reason.
RunResult run(const Equations& eq, const State& start, const Eigen::VectorXd& v_dot,
              const SolverOptions& options, const RunCallbacks& callbacks = {});

/// Goes on from there; rows that were written are not written again.  Throws std::invalid_argument where the
/// continuation is of another integrator or another mechanism.
RunResult run(const Equations& eq, const Continuation& from, const SolverOptions& options,
              const RunCallbacks& callbacks = {});

}  // namespace flexura::mbs
