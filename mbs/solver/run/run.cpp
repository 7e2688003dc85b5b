// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mbs/solver/algebra/finite.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/position/dead_point.hpp"
#include "mbs/solver/run/runner.hpp"
#include "mbs/solver/run/watch/standstill.hpp"

namespace flexura::mbs {

namespace {

/// Where something is wrong any choice of rows that is better serves.
constexpr double kTroubleGain = 1.5;
/// Above, a look at the rows takes longer than a step; they are chosen anew where something is wrong.
constexpr int kMostCoordinates = 100;

}  // namespace

void Runner::take_switches(const std::vector<int>& roots) {
  switches_.take(roots, result_.state, result_.events);
  start_anew();
}

void Runner::start_anew() {
  State& s = result_.state;
  // Velocities that jumped, and constraints that the switch brought in, want the smallest impulse.
  AssembleReport report;
  assemble_velocities(eq_, s, {}, report);
  accelerations_.solve(s, result_.v_dot);
  books_.book().jump(s, result_.v_dot);
  start_integrator();
  method_watch_.restart(s.t);
  long_steps_.forget_beginnings();
}

// At the state reached.
void Runner::start_integrator() {
  integrator_->set_horizon(times_.next(result_.state.t).t);
  integrator_->start(result_.state, result_.v_dot);
  has_history_ = false;
  if (!callbacks_.restart) return;
  books_.drain();
  State shown = result_.state;
  books_.show(shown, result_.v_dot);
  callbacks_.restart(shown, result_.v_dot, kind_of(options_));
}

// What is due at this very time is passed before the next step.
void Runner::look_ahead() {
  while ((stop_ = times_.next(result_.state.t)).is_due && result_.state.t < options_.end_time) pass_event();
  if (stop_.t > goal_) {
    stop_ = {};
    stop_.t = goal_;
  }
  stop_.t = std::min(stop_.t, options_.end_time);
  if (const double reach = leaps_.reach(); reach > 0.0 && result_.state.t + reach < stop_.t) {
    stop_ = {};
    stop_.t = result_.state.t + reach;
    return;
  }
  if (!stop_.is_event && stop_.t < std::min(goal_, options_.end_time)) bounds_.count(result_.state.t);
}

// Behind it, where all that is a function of time has its new value: the state is that before, velocities that
// a drive makes jump excepted.
void Runner::pass_event() {
  times_.pass(stop_);
  books_.drain();
  if (keeps_book_) books_.close(result_.state);
  Sight before;
  see_levels(before);
  result_.state.t = std::min(stop_.after, options_.end_time);
  ++result_.time_events;
  events_.count(result_.state.t);
  pass_jump(before, "step(t, t_0, y_0, t_1, y_1)");
}

void Runner::see_levels(Sight& sight) {
  sight.roots.resize(n_.n_root);
  sight.g.resize(n_.n_lambda);
  eq_.roots(result_.state, *scratch_, sight.roots);
  eq_.position_constraints(result_.state, result_.state.p, *scratch_, sight.g);
}

// Of all that acts, by what is not the state.
void Runner::pass_jump(const Sight& before, const char* remedy) {
  const State& s = result_.state;
  Sight after;
  see_levels(after);
  for (int k = 0; k < n_.n_lambda; ++k)
    if (const double jump = after.g(k) - before.g(k); std::abs(jump) > 1e-9)
      throw IntegrationError(
          fmt::format("what \"{}\" prescribes jumps by {:.3g} (m or rad) at t = {:.9g} s, and no position "
                      "can: lead it over "
                      "with {}",
                      eq_.name_of_constraint(k), -jump, s.t, remedy));
  std::vector<int> roots;
  for (int k = 0; k < n_.n_root; ++k)
    if (before.roots(k) >= 0.0 && after.roots(k) < 0.0) roots.push_back(k);
  if (roots.empty())
    start_anew();
  else
    take_switches(roots);
}

bool Runner::step_once() {
  look_ahead();
  if (result_.state.t >= options_.end_time) return false;
  // Steps grow short where rows are this near to depending on each other, and what they leave open grows like 1 / sigma^2.
  constexpr double kNear = 0.03, kGain = 3.0;
  if (own_ && n_.n_v <= kMostCoordinates) choose_rows_anew(kNear, kGain);
  StepEnd end;
  try {
    end = integrator_->step(stop_.t);
  } catch (const IntegrationError& reason) {
    if (choose_rows_anew(1.0, kTroubleGain)) return true;
    if (!options_.method_is_open) return cross_singularity(reason);
    try {
      return cross_singularity(reason);
    } catch (const IntegrationError&) {
      if (!change_after(reason)) throw;
      return true;
    }
  }
  if (is_watched_ && leaps_.over_switches(end, has_history_)) {
    start_integrator();
    return true;
  }
  if (is_watched_ && leaps_.over_peak(end, *integrator_)) {
    go_back_to_peak(end);
    return true;
  }
  leaps_.widen();
  has_history_ = true;
  long_steps_.take(end.t_end - end.t_begin, n_.n_lambda > 0, result_.state, result_.v_dot);
  const bool goes_on = finish_step(end, *integrator_);
  if (!end.roots.empty()) long_steps_.forget_beginnings();
  if (is_watched_ && method_watch_.step(options_.method, end.t_end, integrator_->counts()) &&
      (goes_on || result_.stopped_as_told))
    watch_method();
  if (is_watched_ && goes_on) prefer_method_for_events();
  if (is_watched_ && goes_on && pace_watch_.step(end.t_end)) refuse_creeping();
  return goes_on;
}

// To where the peak begins, and on from there by steps that are as short as it asks.
void Runner::go_back_to_peak(const StepEnd& end) {
  if (leaps_.is_at_beginning(end)) {
    start_integrator();
    return;
  }
  rows_.enter_step(result_.state.t, end.t_end, end.t_end, *integrator_);
  integrator_->interpolate(end.t_end, result_.state, result_.v_dot);
  books_.drain();
  books_.close(result_.state);
  start_anew();
}

// The run ends where a row that was redundant begins to say something else; rows until then are kept.
void Runner::stop_at_contradiction(const StepEnd& end, Integrator& integrator) {
  const double agrees = contradictions_.last_agreement(result_.state.t, end.t_end, integrator);
  result_.stopped_because = contradictions_.complaint();
  if (agrees <= result_.state.t) return;
  if (keeps_book_)
    rows_.enter_step(result_.state.t, agrees, agrees, integrator);
  else
    rows_.give_equilibria(agrees, agrees, integrator);
  integrator.interpolate(agrees, result_.state, result_.v_dot);
}

// A fixed step that gave way to a pulse and comes back: what a method remembers of much shorter steps is noise
// in a long one.
bool Runner::grows_at_once(const StepEnd& end) {
  if (!(options_.fixed_step > 0.0) || result_.state.t >= options_.end_time) return false;
  const double until = std::min(times_.next(result_.state.t).t, options_.end_time) - result_.state.t;
  const double next = std::min(options_.fixed_step, until);
  return (options_.max_step > 0.0 ? std::min(next, options_.max_step) : next) >
         10.0 * (end.t_end - end.t_begin);
}

void Runner::leave_short_steps() {
  books_.drain();
  if (keeps_book_) books_.close(result_.state);
  start_anew();
}

bool Runner::finish_step(const StepEnd& end, Integrator& integrator) {
  if (contradictions_.watches() && contradictions_.contradicts(end.t_end, integrator)) {
    bool goes_on = true;
    if (&integrator == integrator_.get() && (choose_rows_anew(1.0, kTroubleGain) || pass_rank_loss(goes_on)))
      return goes_on;
    stop_at_contradiction(end, integrator);
    return false;
  }
  if (keeps_book_ && stops_without_algebraic(end, integrator)) return false;
  // Rows that fall on an event show what was before it.
  const bool at_event = stop_.is_event && end.t_end == stop_.t && end.roots.empty();
  const double rows_until = at_event ? std::max(stop_.after, end.t_end) : end.t_end;
  if (keeps_book_) {
    rows_.enter_step(result_.state.t, end.t_end, rows_until, integrator);
    integrator.interpolate(end.t_end, result_.state, result_.v_dot);
  } else {
    rows_.give_equilibria(end.t_end, rows_until, integrator);
    integrator.interpolate(end.t_end, result_.state, result_.v_dot);
    // Equilibria know nothing of the work between them: every one begins its own account.
    books_.book().start(result_.state, result_.v_dot);
    books_.note(books_.closer().drift(result_.state));
  }
  if (callbacks_.progress)
    callbacks_.progress(end.t_end,
                        (end.t_end - options_.start_time) / (options_.end_time - options_.start_time));
  if (!end.roots.empty()) {
    books_.drain();
    if (keeps_book_) books_.close(result_.state);
    take_switches(end.roots);
  }
  if (at_event)
    pass_event();
  else if (end.roots.empty() && grows_at_once(end))
    leave_short_steps();
  if (callbacks_.stop_wanted && callbacks_.stop_wanted()) {
    result_.stopped_because = fmt::format("interrupted at t = {:.9g} s", end.t_end);
    return false;
  }
  // Behind an event that started the integrator anew it has nothing yet to go on with to the bit.
  const bool has_stop = options_.stop_time != 0.0 && options_.stop_time > options_.start_time;
  if (has_stop && end.t_end >= options_.stop_time && has_history_ && end.t_end < options_.end_time) {
    result_.stopped_because = fmt::format("stop_time is reached at t = {:.9g} s", end.t_end);
    result_.stopped_as_told = true;
    return false;
  }
  if (options_.max_steps > 0 && counts().steps >= options_.max_steps && end.t_end < options_.end_time) {
    result_.stopped_because =
        fmt::format("max_steps = {} are used up at t = {:.9g} s", options_.max_steps, end.t_end);
    return false;
  }
  return is_on_its_way();
}

void Runner::open() {
  begin_ = std::chrono::steady_clock::now();
  events_.begin(result_.state.t);
  bounds_.begin(result_.state.t);
  rows_.times().pass_looks(result_.state.t);
  contradictions_.begin(result_.state);
  books_.begin(result_.state);
  if (!resumed_) {
    if (!keeps_book_) {
      // The first row is an equilibrium too.
      integrator_->start(result_.state, result_.v_dot);
      integrator_->interpolate(options_.start_time, result_.state, result_.v_dot);
    } else if (n_.n_root > 0) {
      const std::vector<int> before = result_.state.root;
      eq_.hold_conditions(result_.state, *scratch_);
      if (result_.state.root != before) accelerations_.solve(result_.state, result_.v_dot);
    }
    books_.book().start(result_.state, result_.v_dot);
    if (keeps_book_) books_.closer().judge(result_.state, result_.v_dot);
    rows_.give(result_.state, result_.v_dot);
  }
  if (!(options_.end_time > result_.state.t)) return;
  if (!resumed_ && is_watched_ && stands_still(eq_, options_, result_.state, *scratch_)) {
    change_method("kinematics", "nothing is free to move, the constraints hold all of it");
  } else if (!resumed_ && keeps_book_) {
    start_integrator();
  }
  pace_watch_.change(result_.state.t);
}

// What ends a run cleanly is its reason to stop.
void Runner::stop_where_thrown(const std::function<void()>& what) {
  try {
    what();
  } catch (const IntegrationError& e) {
    result_.stopped_because = with_rank_loss(eq_, result_.state, e.what());
    is_lock_ = result_.stopped_because != e.what();
  } catch (const AssemblyError& e) {
    result_.stopped_because = e.what();
  } catch (const NonFiniteError& e) {
    // Between the ends of a step that were finite.
    books_.drain_what_can_be();
    result_.stopped_because = e.what();
  } catch (...) {
    books_.drain_what_can_be();  // rows before the trouble are worth keeping
    throw;
  }
}

RunResult Runner::run() {
  stop_where_thrown([&] {
    open();
    if (!(options_.end_time > result_.state.t)) return;
    while (step_once())
      if (has_history_ && remembering_.wanted && remembering_.wanted()) hand_out_memory();
    if (has_history_ && !result_.stopped_because.empty() && remembering_.take && remembering_.at_the_end)
      hand_out_memory();
  });
  result_.complete = result_.stopped_because.empty();
  remember();
  books_.show(result_.state, result_.v_dot);
  result_.counts = counts();
  result_.method = options_.method;
  if (result_.method_changes.empty()) result_.method_hint = method_watch_.hint(options_.method);
  result_.energy = books_.book().account();
  const Bookkeeper::Peaks& peaks = books_.peaks();
  if (keeps_book_ && !is_lock_)
    result_.near_rank_loss =
        near_rank_loss(eq_, books_.closer().nearness(), books_.watch().misfit(), options_.tolerance);
  if (keeps_book_) {
    const RankWatch::Nearness& nearness = books_.closer().nearness();
    result_.doubt_of_rows = result_.near_rank_loss.empty()
                                ? std::max(nearness.doubt, nearness.doubt_elsewhere)
                                : nearness.doubt_elsewhere;
  }
  result_.doubt_of_energy =
      std::max(books_.closer().nearness().doubt, books_.closer().nearness().doubt_between);
  result_.largest_energy_error = std::max(before_.largest_energy_error, peaks.energy_error);
  result_.peak_position_drift = std::max(before_.peak_position_drift, peaks.drift.position);
  result_.peak_velocity_drift = std::max(before_.peak_velocity_drift, peaks.drift.velocity);
  result_.wall_time =
      before_.wall_time + std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  return result_;
}

RunResult run(const Equations& eq, const State& start, const Eigen::VectorXd& v_dot,
              const SolverOptions& options, const RunCallbacks& callbacks) {
  return Runner(eq, start, v_dot, options, callbacks).run();
}

RunResult run(const Equations& eq, const Continuation& from, const SolverOptions& options,
              const RunCallbacks& callbacks) {
  Runner runner(eq, from.state, from.v_dot, options, callbacks);
  runner.resume(from);
  return runner.run();
}

}  // namespace flexura::mbs
