// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mbs/solver/algebra/finite.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/position/dead_point.hpp"
#include "mbs/solver/run/runner.hpp"

namespace flexura::mbs {

namespace {

// More switchings of one switch within this part of the run are an accumulation, like the last bounces of a
// ball between impacts, or a relay whose own output takes its input back across the level.  From kManyEventsAtOnce on a
// switch has a hysteresis.
constexpr int kMostEventsAtOnce = 200, kManyEventsAtOnce = 20, kMostPasses = 20;
constexpr double kAtOnce = 1e-10;
// Kinks that come so much faster than the run are left to the error control: what trembles about a kink without
// a jump would only be held up.
constexpr double kTrembling = 1e-3;

}  // namespace

void Runner::enter_look(double t, Integrator& integrator) {
  Instant& look = books_.next(BookEntry::Kind::look).row;
  integrator.interpolate(t, look.state, look.v_dot);
  books_.enter();
}

void Runner::enter_step(double t_begin, double t_end, double rows_until, Integrator& integrator) {
  BookEntry& step = books_.next(BookEntry::Kind::step);
  step.t_end = t_end;
  const std::array<double, 3> times = EnergyBook::node_times(t_begin, t_end);
  for (int i = 0; i < 3; ++i) integrator.interpolate(times[i], step.nodes[i].state, step.nodes[i].v_dot);
  if (n_.n_lambda > 0 || callbacks_.step) integrator.interpolate(t_begin, step.begin.state, step.begin.v_dot);
  books_.enter();
  double seen = t_begin;
  for (;;) {
    if (const double look = next_look_until(rows_until); look < kNever) {
      enter_look(std::min(look, t_end), integrator);
      ++next_look_;
      seen = look;
      continue;
    }
    if (!next_row_is_until(rows_until)) break;
    seen = row_time(next_row_++);
    Instant& row = books_.next(BookEntry::Kind::row).row;
    integrator.interpolate(std::min(seen, t_end), row.state, row.v_dot);
    books_.enter();
    pass_looks(seen);
  }
  if (seen < t_end && callbacks_.look && callbacks_.wants_look && callbacks_.wants_look(t_begin, t_end))
    enter_look(t_end, integrator);
  books_.next(BookEntry::Kind::end);
  books_.enter();
}

void Runner::write_equilibria_until(double t_end, double rows_until, Integrator& integrator) {
  for (;;) {
    if (const double look = next_look_until(rows_until); look < kNever) {
      integrator.interpolate(std::min(look, t_end), row_.state, row_.v_dot);
      callbacks_.look(row_.state, row_.v_dot);
      ++next_look_;
      continue;
    }
    if (!next_row_is_until(rows_until)) break;
    const double t = row_time(next_row_++);
    integrator.interpolate(std::min(t, t_end), row_.state, row_.v_dot);
    write_row(row_.state, row_.v_dot);
    pass_looks(t);
  }
}

// Far from t = 0 two events cannot lie closer than the round-off of the time.
double Runner::at_once(int which) const {
  return std::max((eq_.is_kink(which) ? kTrembling : kAtOnce) * (options_.end_time - options_.start_time),
                  1e5 * std::numeric_limits<double>::epsilon() * std::abs(result_.state.t));
}

int Runner::switchings_at_once(int which) const {
  const double since = result_.state.t - at_once(which);
  int times = 0;
  for (auto event = result_.events.rbegin(); event != result_.events.rend() && event->t > since; ++event)
    if (event->which == which) ++times;
  return times;
}

void Runner::end_endless(int which) {
  const int times = switchings_at_once(which);
  if (times <= kMostEventsAtOnce) return;
  if (!eq_.is_kink(which))
    throw IntegrationError(
        fmt::format("{} switches without end at t = {:.9g} s ({} times within {:.2g} s): give the "
                    "contact or the switch a hysteresis, damping or a compliant law",
                    eq_.describe_root(which), result_.state.t, times, at_once(which)));
  result_.state.root[static_cast<std::size_t>(which)] = 0;
}

// What takes a switch to and fro at once may be the round-off of its own function (teeth that graze each other at hardly any
// speed): from then on it counts only where it is clearly below 0. A relay whose output takes its input back across the
// level goes on as before, since it falls below that, too.
void Runner::give_hysteresis(const std::vector<int>& roots) {
  constexpr double kClearly = 10.0;  // of what it was below at a switching
  const auto is_at_once = [this](int which) {
    return !eq_.is_kink(which) && switchings_at_once(which) > kManyEventsAtOnce;
  };
  if (std::ranges::none_of(roots, is_at_once)) return;
  State& s = result_.state;
  Eigen::VectorXd values(n_.n_root);
  eq_.roots(s, *scratch_, values);
  if (s.hysteresis.size() == 0) s.hysteresis.setZero(n_.n_root);
  for (const int which : roots)
    if (is_at_once(which))
      s.hysteresis(which) = std::max(s.hysteresis(which), kClearly * std::abs(values(which)));
}

void Runner::change_switches(const std::vector<int>& roots) {
  State& s = result_.state;
  give_hysteresis(roots);
  for (const int which : roots) {
    const bool jumped = eq_.on_root(which, s, *scratch_);
    result_.events.push_back({s.t, which, jumped});
  }
  for (const int which : roots) end_endless(which);
}

void Runner::take_switches(const std::vector<int>& roots) {
  change_switches(roots);
  // What they changed may be what conditions in formulas look at.
  std::vector<int> changed = roots, others;
  Eigen::VectorXd values(n_.n_root);
  for (int pass = 0; pass < kMostPasses; ++pass) {
    eq_.roots(result_.state, *scratch_, values);
    others.clear();
    for (int k = 0; k < n_.n_root; ++k)
      if (eq_.is_condition(k) && values(k) < 0.0 && std::ranges::find(changed, k) == changed.end())
        others.push_back(k);
    if (others.empty()) break;
    change_switches(others);
    changed = others;
  }
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
  n_anchors_ = 0;
}

// At the state reached.
void Runner::start_integrator() {
  integrator_->set_horizon(times_.next(result_.state.t).t);
  integrator_->start(result_.state, result_.v_dot);
  has_history_ = false;
  if (!callbacks_.restart) return;
  books_.drain();
  callbacks_.restart(result_.state, result_.v_dot, kind_of(options_));
}

// What is due at this very time is passed before the next step.
// What is a function of time has so many jumps, or bends so often, that the run would never end.
void Runner::refuse_endless(long stops, double most, const char* what) const {
  constexpr long kEnough = 20000;
  if (stops != kEnough) return;
  const double t = result_.state.t, rate = static_cast<double>(stops) / (t - stops_since_);
  if (!(rate * (options_.end_time - t) > most)) return;
  throw IntegrationError(
      fmt::format("what is a function of time alone {} {:.2g} times a second ({} times until t = {:.6g} s), "
                  "{:.1g} times until the end, and a "
                  "step can pass none of them: write its mean over such short times, or shorten the run",
                  what, rate, stops, t, rate * (options_.end_time - t)));
}

void Runner::look_ahead() {
  while ((stop_ = times_.next(result_.state.t)).is_due && result_.state.t < options_.end_time) pass_event();
  stop_.t = std::min(stop_.t, options_.end_time);
  if (reach_ > 0.0 && result_.state.t + reach_ < stop_.t) {
    stop_ = {};
    stop_.t = result_.state.t + reach_;
    return;
  }
  if (!stop_.is_event && stop_.t < options_.end_time) refuse_endless(++bounds_, kMostBounds, "turns");
}

// Behind it, where all that is a function of time has its new value: the state is that before, velocities that
// a drive makes jump excepted.
void Runner::pass_event() {
  times_.pass(stop_);
  books_.drain();
  State& s = result_.state;
  if (keeps_book_) books_.close(s);
  Eigen::VectorXd before(n_.n_root), after(n_.n_root), g_before(n_.n_lambda), g_after(n_.n_lambda);
  eq_.roots(s, *scratch_, before);
  eq_.position_constraints(s, s.p, *scratch_, g_before);
  s.t = std::min(stop_.after, options_.end_time);
  eq_.position_constraints(s, s.p, *scratch_, g_after);
  for (int k = 0; k < n_.n_lambda; ++k)
    if (const double jump = g_after(k) - g_before(k); std::abs(jump) > 1e-9)
      throw IntegrationError(
          fmt::format("what \"{}\" prescribes jumps by {:.3g} (m or rad) at t = {:.9g} s, and no position "
                      "can: lead it over "
                      "with step(t, t_0, y_0, t_1, y_1)",
                      eq_.name_of_constraint(k), -jump, s.t));
  eq_.roots(s, *scratch_, after);
  std::vector<int> roots;
  for (int k = 0; k < n_.n_root; ++k)
    if (before(k) >= 0.0 && after(k) < 0.0 && before(k) - after(k) > 1e-9 * (std::abs(before(k)) - after(k)))
      roots.push_back(k);
  ++result_.time_events;
  refuse_endless(++events_, kMostTimeEvents, "jumps or bends");
  if (roots.empty())
    start_anew();
  else
    take_switches(roots);
}

bool Runner::step_once() {
  look_ahead();
  if (result_.state.t >= options_.end_time) return false;
  StepEnd end;
  try {
    end = integrator_->step(stop_.t);
  } catch (const IntegrationError& reason) {
    if (!options_.method_is_open) return cross_singularity(reason);
    try {
      return cross_singularity(reason);
    } catch (const IntegrationError&) {
      if (!change_after(reason)) throw;
      return true;
    }
  }
  if (is_watched_ && leaps_over_switches(end)) return true;
  if (is_watched_ && leaps_over_peak(end)) {
    go_back_to_peak(end);
    return true;
  }
  widen_reach();
  // The longest of the last steps: what the motion allows away from the trouble.
  good_step_ = std::max(end.t_end - end.t_begin, 0.99 * good_step_);
  has_history_ = true;
  if (n_.n_lambda > 0 && end.t_end - end.t_begin > 0.1 * good_step_) {
    anchors_[next_anchor_].state = result_.state;
    anchors_[next_anchor_].v_dot = result_.v_dot;
    next_anchor_ = (next_anchor_ + 1) % kAnchors;
    n_anchors_ = std::min(n_anchors_ + 1, kAnchors);
  }
  const bool goes_on = finish_step(end, *integrator_);
  if (!end.roots.empty()) n_anchors_ = 0;
  if (is_watched_ && method_watch_.step(options_.method, end.t_end, integrator_->counts()) &&
      (goes_on || result_.stopped_as_told))
    watch_method();
  if (is_watched_ && goes_on && pace_watch_.step(end.t_end)) refuse_creeping();
  return goes_on;
}

// Rows left out as redundant, at a time within the last step. What Newton's method left of the kept ones is
// not theirs.
bool Runner::contradicts(double t, Integrator& integrator) {
  const auto judge = keeps_book_ ? RowWatch::Judge::all : RowWatch::Judge::positions;
  integrator.interpolate(t, row_.state, row_.v_dot);
  if (watch_.look(row_.state, judge).left_out <= 1.0) return false;
  watch_closer_.close(row_.state);
  const RowWatch::Opening& open = watch_.look(row_.state, judge);
  // Near a dead point loops are not closed further.
  return open.left_out > (open.kept <= 1e-3 ? 1.0 : RowWatch::allowed(options_.tolerance));
}

// The run ends where a row that was redundant begins to say something else; rows until then are kept.
void Runner::stop_at_contradiction(const StepEnd& end, Integrator& integrator) {
  double agrees = result_.state.t, contradictory = end.t_end;
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (agrees + contradictory);
    (contradicts(middle, integrator) ? contradictory : agrees) = middle;
  }
  contradicts(end.t_end, integrator);
  result_.stopped_because = watch_.complaint(end.t_end, agrees, RowWatch::allowed(options_.tolerance));
  if (agrees <= result_.state.t) return;
  if (keeps_book_)
    enter_step(result_.state.t, agrees, agrees, integrator);
  else
    write_equilibria_until(agrees, agrees, integrator);
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
  if (watch_.watches() && contradicts(end.t_end, integrator)) {
    bool goes_on = true;
    if (&integrator == integrator_.get() && pass_rank_loss(goes_on)) return goes_on;
    stop_at_contradiction(end, integrator);
    return false;
  }
  // Rows that fall on an event show what was before it.
  const bool at_event = stop_.is_event && end.t_end == stop_.t && end.roots.empty();
  const double rows_until = at_event ? std::max(stop_.after, end.t_end) : end.t_end;
  if (keeps_book_) {
    enter_step(result_.state.t, end.t_end, rows_until, integrator);
    integrator.interpolate(end.t_end, result_.state, result_.v_dot);
  } else {
    write_equilibria_until(end.t_end, rows_until, integrator);
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
  if (options_.stop_time > options_.start_time && end.t_end >= options_.stop_time && has_history_ &&
      end.t_end < options_.end_time) {
    result_.stopped_because = fmt::format("stop_time is reached at t = {:.9g} s", end.t_end);
    result_.stopped_as_told = true;
    return false;
  }
  if (options_.max_steps > 0 && counts().steps >= options_.max_steps && end.t_end < options_.end_time) {
    result_.stopped_because =
        fmt::format("max_steps = {} are used up at t = {:.9g} s", options_.max_steps, end.t_end);
    return false;
  }
  return result_.state.t < options_.end_time;
}

RunResult Runner::run() {
  begin_ = std::chrono::steady_clock::now();
  stops_since_ = result_.state.t;
  pass_looks(result_.state.t);
  bool is_lock = false;
  watch_.begin(result_.state);
  books_.begin(result_.state);
  try {
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
      write_row(result_.state, result_.v_dot);
    }
    if (options_.end_time > result_.state.t) {
      if (!resumed_ && is_watched_ && stands_still()) {
        change_method("kinematics", "nothing is free to move, the constraints hold all of it");
      } else if (!resumed_ && keeps_book_) {
        start_integrator();
      }
      pace_watch_.change(result_.state.t);
      while (step_once())
        if (has_history_ && remembering_.wanted && remembering_.wanted()) hand_out_memory();
      if (has_history_ && !result_.stopped_because.empty() && remembering_.take && remembering_.at_the_end)
        hand_out_memory();
    }
    result_.complete = result_.stopped_because.empty();
  } catch (const IntegrationError& e) {
    result_.stopped_because = with_rank_loss(eq_, result_.state, e.what());
    is_lock = result_.stopped_because != e.what();
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
  remember();
  result_.counts = counts();
  result_.method = options_.method;
  if (result_.method_changes.empty()) result_.method_hint = method_watch_.hint(options_.method);
  result_.energy = books_.book().account();
  const Bookkeeper::Peaks& peaks = books_.peaks();
  if (keeps_book_ && !is_lock)
    result_.near_rank_loss =
        near_rank_loss(eq_, books_.closer().nearness(), books_.watch().misfit(), options_.tolerance);
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
