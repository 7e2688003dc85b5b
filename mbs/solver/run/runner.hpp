// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/integrators/known_times.hpp"
#include "mbs/solver/integrators/peak_watch.hpp"
#include "mbs/solver/position/projection.hpp"
#include "mbs/solver/position/row_watch.hpp"
#include "mbs/solver/run/bookkeeper.hpp"
#include "mbs/solver/run/make_integrator.hpp"
#include "mbs/solver/run/method_watch.hpp"
#include "mbs/solver/run/pace_watch.hpp"
#include "mbs/solver/run/run_memory.hpp"

namespace flexura::mbs {

/// One run under way (run.hpp, run_memory.hpp): its steps, rows and events in run.cpp, what is done where an
/// integrator does not come on in run_rescue.cpp, what it remembers and goes on from in run_memory.cpp.
class Runner {
 public:
  Runner(const Equations& eq, const State& start, const Eigen::VectorXd& v_dot, const SolverOptions& options,
         const RunCallbacks& callbacks, const Remembering& remembering = {})
      : eq_(eq),
        n_(eq.sizes()),
        options_(options),
        callbacks_(callbacks),
        remembering_(remembering),
        scratch_(eq.make_scratch()),
        integrator_(make_integrator(eq, options)),
        method_watch_(eq, options),
        pace_watch_(options),
        peak_watch_(eq),
        is_watched_(kind_of(options).integrates),
        accelerations_(eq),
        watch_(eq),
        watch_closer_(eq, options),
        keeps_book_(kind_of(options).is_motion),
        books_(eq, options, callbacks.row, callbacks.look, callbacks.step,
               callbacks.rows_beside && keeps_book_),
        times_(eq, options) {
    result_.state = start;
    result_.state.t = options.start_time;
    result_.v_dot = v_dot;
    n_rows_ = static_cast<long>(
        std::floor((options.end_time - options.start_time) / options.output_step * (1 + 1e-12)));
  }

  void resume(const Continuation& from);
  void resume(const RunMemory& from);
  RunResult run();

 private:
  static constexpr std::size_t kAnchors = 3;
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  // Minutes of restarts, and of steps; a pulse-width modulation of 20 kHz has 400,000 edges in ten seconds.
  static constexpr double kMostTimeEvents = 5e5, kMostBounds = 1e8;

  void remember();
  void hand_out_memory();
  StepCounts counts() const;
  long next_row_at(double t, long said) const;
  void write_row(const State& s, const Eigen::VectorXd& v_dot) {
    if (callbacks_.row) callbacks_.row(s, v_dot, books_.book().account());
  }
  double row_time(long k) const {
    // The last row stands at the end time even where the step does not divide the run.
    return k > n_rows_ ? options_.end_time
                       : std::min(options_.start_time + static_cast<double>(k) * options_.output_step,
                                  options_.end_time);
  }
  bool next_row_is_until(double t) const {
    return row_time(next_row_) <= t && row_time(next_row_) > row_time(next_row_ - 1);
  }
  // The next time that others look at, if it lies before the next row and until t; else infinite.
  double next_look_until(double t) const {
    if (!callbacks_.look || next_look_ >= callbacks_.look_at.size()) return kNever;
    const double look = callbacks_.look_at[next_look_];
    return look <= t && look < row_time(next_row_) ? look : kNever;
  }
  // Those until t are past.
  void pass_looks(double t) {
    while (next_look_ < callbacks_.look_at.size() && callbacks_.look_at[next_look_] <= t) ++next_look_;
  }
  void enter_look(double t, Integrator& integrator);
  void enter_step(double t_begin, double t_end, double rows_until, Integrator& integrator);
  void write_equilibria_until(double t_end, double rows_until, Integrator& integrator);
  void take_switches(const std::vector<int>& roots);
  void change_switches(const std::vector<int>& roots);
  void start_anew();
  void start_integrator();
  void look_ahead();
  void refuse_endless(long stops, double most, const char* what) const;
  bool grows_at_once(const StepEnd& end);
  void leave_short_steps();
  void pass_event();
  double at_once(int which) const;
  int switchings_at_once(int which) const;
  void end_endless(int which);
  void give_hysteresis(const std::vector<int>& roots);
  bool step_once();  // false ends the run
  bool leaps_over_switches(const StepEnd& end);
  bool leaps_over_peak(StepEnd& end);
  void widen_reach();
  void go_back_to_peak(const StepEnd& end);
  bool finish_step(const StepEnd& end, Integrator& integrator);
  bool cross_singularity(const IntegrationError& reason);
  bool contradicts(double t, Integrator& integrator);
  void stop_at_contradiction(const StepEnd& end, Integrator& integrator);
  bool leap(const Instant& from, bool& goes_on);
  bool leap_across(double least_way, bool& goes_on);
  bool pass_rank_loss(bool& goes_on);
  bool start_again(State& s, Eigen::VectorXd& v_dot);
  void watch_method();
  void refuse_creeping() const;
  std::string fastest() const;
  bool stands_still() const;
  bool change_after(const IntegrationError& reason);
  void change_method(const std::string& method, const std::string& why);
  void remember_own(History& history);

  const Equations& eq_;
  Sizes n_;
  SolverOptions options_;
  const RunCallbacks& callbacks_;
  const Remembering remembering_;
  std::unique_ptr<Equations::Scratch> scratch_;
  std::unique_ptr<Integrator> integrator_, hopper_;
  MethodWatch method_watch_;
  PaceWatch pace_watch_;
  PeakWatch peak_watch_;
  double reach_ = 0.0;            // of a step, after a peak was leapt over [s]; 0: no bound
  std::optional<StepEnd> leapt_;  // what a step that was made again had led to
  std::set<int> harmless_;        // switches at which nothing was found that way
  bool is_watched_;
  AccelerationSolver accelerations_;
  RowWatch watch_;
  LoopCloser watch_closer_;
  bool keeps_book_;
  Bookkeeper books_;
  RunResult result_;
  Instant row_;
  KnownTimes times_;
  KnownTimes::Stop stop_;         // of the step under way
  long events_ = 0, bounds_ = 0;  // known beforehand, passed since the time
  double stops_since_ = 0.0;
  double good_step_ = 0.0;
  // The beginnings of the last long steps.
  std::array<Instant, kAnchors> anchors_;
  std::size_t n_anchors_ = 0, next_anchor_ = 0;
  long n_rows_ = 0, next_row_ = 1;
  std::size_t next_look_ = 0;
  bool resumed_ = false;
  // The integrator has taken a step since its last start; between the two it has no history yet.
  bool has_history_ = false;
  RunMemory before_;           // of a run that goes on: its figures until then
  StepCounts counts_at_once_;  // of the integrator when it took up its history
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace flexura::mbs
