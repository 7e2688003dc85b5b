// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/integrators/known_times.hpp"
#include "mbs/solver/position/projection.hpp"
#include "mbs/solver/run/bookkeeper.hpp"
#include "mbs/solver/run/make_integrator.hpp"
#include "mbs/solver/run/run_memory.hpp"
#include "mbs/solver/run/step_rows.hpp"
#include "mbs/solver/run/switch_events.hpp"
#include "mbs/solver/run/watch/contradiction_watch.hpp"
#include "mbs/solver/run/watch/leap_watch.hpp"
#include "mbs/solver/run/watch/long_steps.hpp"
#include "mbs/solver/run/watch/method_watch.hpp"
#include "mbs/solver/run/watch/pace_watch.hpp"
#include "mbs/solver/run/watch/stop_limit.hpp"

namespace flexura::mbs {

/// One run under way (run.hpp, run_memory.hpp): its steps, rows and events in run.cpp, what is done where an
/// integrator does not come on in run_rescue.cpp, what it remembers and goes on from in run_memory.cpp,
/// how it is led from outside in guided_run.cpp.
class Runner {
 public:
  Runner(const Equations& eq, const State& start, const Eigen::VectorXd& v_dot, const SolverOptions& options,
         const RunCallbacks& callbacks, const Remembering& remembering = {})
      : given_(eq),
        own_(eq.copy_for_rows()),
        eq_(own_ ? *own_ : eq),
        n_(eq.sizes()),
        options_(options),
        callbacks_(callbacks),
        remembering_(remembering),
        scratch_(eq_.make_scratch()),
        integrator_(make_integrator(eq_, options)),
        method_watch_(eq_, options),
        pace_watch_(options),
        leaps_(eq_, options),
        is_watched_(kind_of(options).integrates),
        accelerations_(eq_),
        keeps_book_(kind_of(options).is_motion),
        contradictions_(eq_, options, keeps_book_),
        switches_(eq_, *scratch_, options),
        books_(eq_, given_, options, callbacks.row, callbacks.look, callbacks.step,
               callbacks.rows_beside && keeps_book_),
        rows_(eq_, options, callbacks, books_),
        times_(eq_, options),
        // Minutes of restarts, and of steps; a pulse-width modulation of 20 kHz has 400,000 edges in ten seconds.
        events_("jumps or bends", 5e5, options.end_time),
        bounds_("turns", 1e8, options.end_time) {
    result_.state = start;
    result_.state.t = options.start_time;
    result_.v_dot = v_dot;
  }

  void resume(const Continuation& from);
  void resume(const RunMemory& from);
  RunResult run();

  // Led from outside (guided_run.hpp).
  /// Steps until t, the last one ends there; false where the run has stopped before (stopped_because()).
  bool go_to(double t);
  /// Inputs have these values added from the present time on.
  void set_inputs(const Eigen::VectorXd& u) { inputs_ = u; }
  void begin_anew() { is_to_begin_anew_ = true; }
  double time() const { return result_.state.t; }
  Instant shown();
  EnergyAccount account(const Instant& at) { return books_.book().at_row(at.state, at.v_dot); }
  const std::string& stopped_because() const { return result_.stopped_because; }
  const std::vector<std::string>& method_changes() const { return result_.method_changes; }

 private:
  // What shows at one state that something acts in another way than before.
  struct Sight {
    Eigen::VectorXd roots, g, v_dot, c_rate;
  };
  void open();
  void stop_where_thrown(const std::function<void()>& what);
  bool is_on_its_way() const {
    // What is left is too little for a step.
    const double close =
        16.0 * std::numeric_limits<double>::epsilon() *
        std::max(std::abs(result_.state.t), 1e-3 * (options_.end_time - options_.start_time));
    return result_.state.t < options_.end_time && goal_ - result_.state.t > close;
  }
  void see_levels(Sight& sight);
  void see(Sight& sight);
  bool differs(const Sight& now) const;
  void take_changes();
  void pass_jump(const Sight& before, const char* remedy);
  void remember();
  void hand_out_memory();
  StepCounts counts() const;
  void take_switches(const std::vector<int>& roots);
  void start_anew();
  void start_integrator();
  void look_ahead();
  bool grows_at_once(const StepEnd& end);
  void leave_short_steps();
  void pass_event();
  bool step_once();  // false ends the run
  void go_back_to_peak(const StepEnd& end);
  bool finish_step(const StepEnd& end, Integrator& integrator);
  bool cross_singularity(const IntegrationError& reason);
  void stop_at_contradiction(const StepEnd& end, Integrator& integrator);
  bool stops_without_algebraic(const StepEnd& end, Integrator& integrator);
  bool leap(const Instant& from, bool& goes_on);
  bool leap_across(double least_way, bool& goes_on);
  bool pass_rank_loss(bool& goes_on);
  bool choose_rows_anew(double near, double gain);
  void remember_rows(History& history);
  bool start_again(State& s, Eigen::VectorXd& v_dot);
  void watch_method();
  void prefer_method_for_events();
  void refuse_creeping();
  bool change_after(const IntegrationError& reason);
  void change_method(const std::string& method, const std::string& why);
  void remember_own(History& history);

  const Equations& given_;          // what was asked for
  std::unique_ptr<Equations> own_;  // the same with rows that this run chooses; may be null
  const Equations& eq_;             // one of them: that of all steps
  State chosen_at_;                 // where own_'s rows were chosen; empty: as given
  double tried_at_ = 1.0;           // the independence of rows at which others were no better
  Sizes n_;
  SolverOptions options_;
  const RunCallbacks& callbacks_;
  const Remembering remembering_;
  std::unique_ptr<Equations::Scratch> scratch_;
  std::unique_ptr<Integrator> integrator_, hopper_;
  MethodWatch method_watch_;
  PaceWatch pace_watch_;
  LeapWatch leaps_;
  bool is_watched_;
  AccelerationSolver accelerations_;
  bool keeps_book_;
  ContradictionWatch contradictions_;
  SwitchEvents switches_;
  Bookkeeper books_;
  StepRows rows_;
  RunResult result_;
  KnownTimes times_;
  KnownTimes::Stop stop_;      // of the step under way
  StopLimit events_, bounds_;  // known beforehand
  double goal_ = std::numeric_limits<double>::infinity();
  bool is_open_ = false, is_lock_ = false;
  // Led from outside: what was seen where the run stands, and the inputs from there on.
  Sight seen_;
  Eigen::VectorXd inputs_;
  bool is_to_begin_anew_ = false;
  LongSteps long_steps_;
  bool resumed_ = false;
  // The integrator has taken a step since its last start; between the two it has no history yet.
  bool has_history_ = false;
  RunMemory before_;           // of a run that goes on: its figures until then
  StepCounts counts_at_once_;  // of the integrator when it took up its history
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace flexura::mbs
