// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "mbs/solver/accelerations.hpp"
#include "mbs/solver/assemble.hpp"
#include "mbs/solver/bookkeeper.hpp"
#include "mbs/solver/dead_point.hpp"
#include "mbs/solver/known_times.hpp"
#include "mbs/solver/method_watch.hpp"
#include "mbs/solver/projection.hpp"
#include "mbs/solver/remembered.hpp"
#include "mbs/solver/row_watch.hpp"
#include "mbs/solver/run_memory.hpp"

namespace flexura::mbs {

namespace {

// More switchings of one switch within this part of the run are an accumulation, like the last bounces of a
// ball between impacts, or a relay whose own output takes its input back across the level.
constexpr int kMostEventsAtOnce = 20;
constexpr double kAtOnce = 1e-10;

constexpr int kMostHops = 1000;
constexpr std::size_t kAnchors = 3;
constexpr std::size_t kMostChanges = 20;

// The last entry of a history is the number of those before it: one that is missing shifts the others, which might
// by chance make sense all the same.
std::vector<double> sealed(std::vector<double> values) {
  values.push_back(static_cast<double>(values.size()));
  return values;
}
std::vector<double> opened(std::vector<double> values) {
  if (values.empty() || values.back() != static_cast<double>(values.size() - 1)) refuse_history();
  values.pop_back();
  return values;
}

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
        is_watched_(options.method == "ida" || options.method == "radau" ||
                    options.method == "generalised_alpha" || options.method == "runge_kutta"),
        accelerations_(eq),
        watch_(eq),
        watch_closer_(eq, options),
        keeps_book_(options.method != "quasi_statics"),
        books_(eq, options, callbacks.row, callbacks.rows_beside && keeps_book_),
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
                       : std::min(options_.start_time + k * options_.output_step, options_.end_time);
  }
  bool next_row_is_until(double t) const {
    return row_time(next_row_) <= t && row_time(next_row_) > row_time(next_row_ - 1);
  }
  void enter_step(double t_begin, double t_end, double rows_until, Integrator& integrator);
  void write_equilibria_until(double t_end, double rows_until, Integrator& integrator);
  void take_switches(const std::vector<int>& roots);
  void change_switches(const std::vector<int>& roots);
  void start_anew();
  void look_ahead();
  bool grows_at_once(const StepEnd& end);
  void leave_short_steps();
  void pass_event();
  void refuse_endless(int which) const;
  bool step_once();  // false ends the run
  bool finish_step(const StepEnd& end, Integrator& integrator);
  bool hop(const IntegrationError& reason);
  bool contradicts(double t, Integrator& integrator);
  bool stop_at_contradiction(const StepEnd& end, Integrator& integrator);
  bool leap(const Instant& from, bool& goes_on);
  bool start_again(State& s, Eigen::VectorXd& v_dot);
  void watch_method();
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
  bool is_watched_;
  AccelerationSolver accelerations_;
  RowWatch watch_;
  LoopCloser watch_closer_;
  bool keeps_book_;
  Bookkeeper books_;
  RunResult result_;
  Instant row_;
  KnownTimes times_;
  KnownTimes::Stop stop_;  // of the step under way
  double good_step_ = 0.0;
  // The beginnings of the last long steps.
  std::array<Instant, kAnchors> anchors_;
  std::size_t n_anchors_ = 0, next_anchor_ = 0;
  long n_rows_ = 0, next_row_ = 1;
  bool resumed_ = false;
  // The integrator has taken a step since its last start; between the two it has no history yet.
  bool has_history_ = false;
  RunMemory before_;           // of a run that goes on: its figures until then
  StepCounts counts_at_once_;  // of the integrator when it took up its history
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

void Runner::enter_step(double t_begin, double t_end, double rows_until, Integrator& integrator) {
  BookEntry& step = books_.next(BookEntry::Kind::step);
  step.t_end = t_end;
  const std::array<double, 3> times = EnergyBook::node_times(t_begin, t_end);
  for (int i = 0; i < 3; ++i) integrator.interpolate(times[i], step.nodes[i].state, step.nodes[i].v_dot);
  books_.enter();
  for (; next_row_is_until(rows_until); ++next_row_) {
    Instant& row = books_.next(BookEntry::Kind::row).row;
    integrator.interpolate(std::min(row_time(next_row_), t_end), row.state, row.v_dot);
    books_.enter();
  }
  books_.next(BookEntry::Kind::end);
  books_.enter();
}

void Runner::write_equilibria_until(double t_end, double rows_until, Integrator& integrator) {
  for (; next_row_is_until(rows_until); ++next_row_) {
    integrator.interpolate(std::min(row_time(next_row_), t_end), row_.state, row_.v_dot);
    write_row(row_.state, row_.v_dot);
  }
}

void Runner::refuse_endless(int which) const {
  const double t = result_.state.t, duration = options_.end_time - options_.start_time;
  // Far from t = 0 two events cannot lie closer than the round-off of the time.
  const double span =
      std::max(kAtOnce * duration, 1e5 * std::numeric_limits<double>::epsilon() * std::abs(t));
  int times = 0;
  for (auto event = result_.events.rbegin(); event != result_.events.rend() && t - event->t < span; ++event)
    if (event->which == which && ++times > kMostEventsAtOnce)
      throw IntegrationError(
          fmt::format("{} switches without end at t = {:.9g} s ({} times within {:.2g} s): give the "
                      "contact or the switch a hysteresis, damping or a compliant law",
                      eq_.describe_root(which), t, times, span));
}

void Runner::change_switches(const std::vector<int>& roots) {
  State& s = result_.state;
  for (const int which : roots) {
    const bool jumped = eq_.on_root(which, s, *scratch_);
    result_.events.push_back({s.t, which, jumped});
  }
  for (const int which : roots) refuse_endless(which);
}

void Runner::take_switches(const std::vector<int>& roots) {
  change_switches(roots);
  // What they changed may be what conditions in formulas look at.
  std::vector<int> changed = roots, others;
  Eigen::VectorXd values(n_.n_root);
  for (int pass = 0; pass < kMostEventsAtOnce; ++pass) {
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
  integrator_->set_horizon(times_.next(s.t).t);
  integrator_->start(s, result_.v_dot);
  has_history_ = false;
  n_anchors_ = 0;
}

// What is due at this very time is passed before the next step.
void Runner::look_ahead() {
  while ((stop_ = times_.next(result_.state.t)).is_due && result_.state.t < options_.end_time) pass_event();
  stop_.t = std::min(stop_.t, options_.end_time);
}

// Behind it, where all that is a function of time has its new value: the state is that before, velocities that
// a drive makes jump excepted.
void Runner::pass_event() {
  times_.pass(stop_);
  books_.settle();
  State& s = result_.state;
  if (keeps_book_) books_.close(s);
  Eigen::VectorXd before(n_.n_root), after(n_.n_root), g_before(n_.n_lambda), g_after(n_.n_lambda);
  eq_.roots(s, *scratch_, before);
  eq_.position_constraints(s.t, s.p, *scratch_, g_before);
  s.t = std::min(stop_.after, options_.end_time);
  eq_.position_constraints(s.t, s.p, *scratch_, g_after);
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
    if (!options_.method_is_open) return hop(reason);
    try {
      return hop(reason);
    } catch (const IntegrationError&) {
      if (!change_after(reason)) throw;
      return true;
    }
  }
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
  return goes_on;
}

// A state to start an integrator from, on the constraints; false where there is none.
bool Runner::start_again(State& s, Eigen::VectorXd& v_dot) {
  try {
    if (!Projector(eq_).project(s)) return false;
    accelerations_.solve(s, v_dot);
  } catch (const std::runtime_error&) {
    return false;
  }
  return true;
}

void Runner::watch_method() {
  State s = result_.state;
  Eigen::VectorXd v_dot = result_.v_dot;
  if (!start_again(s, v_dot)) return;
  const std::string method = method_watch_.look(options_.method, s, v_dot);
  if (!method.empty())
    change_method(method, fmt::format("it is about {:.0f} times as fast there", method_watch_.last_gain()));
}

bool Runner::change_after(const IntegrationError& reason) {
  if (result_.method_changes.size() >= kMostChanges) return false;
  State s = result_.state;
  Eigen::VectorXd v_dot = result_.v_dot;
  if (!start_again(s, v_dot)) return false;
  const std::string method = method_watch_.after_failure(options_.method, s, v_dot);
  if (method.empty()) return false;
  change_method(method, reason.what());
  return true;
}

void Runner::change_method(const std::string& method, const std::string& why) {
  result_.method_changes.push_back(
      fmt::format("from {} to {} at t = {:.6g} s: {}", options_.method, method, result_.state.t, why));
  before_.counts = counts();
  counts_at_once_ = {};
  options_.method = method;
  integrator_ = make_integrator(eq_, options_);
  method_watch_.change();
  start_again(result_.state, result_.v_dot);
  integrator_->set_horizon(times_.next(result_.state.t).t);
  integrator_->start(result_.state, result_.v_dot);
  has_history_ = false;
}

bool Runner::hop(const IntegrationError& reason) {
  // Near a dead point, where constraints lose rank for an instant, round-off of g is amplified by 1 / sigma^2
  // and an implicit method cannot converge to a tight tolerance however short its step.  Accelerations are
  // finite there: a few explicit steps lead across.
  if ((options_.method != "ida" && options_.method != "radau" && options_.method != "generalised_alpha") ||
      n_.n_lambda == 0 || result_.counts.hops >= kMostHops)
    throw reason;
  // From where the run stands, or, where that is too near to the singular position for round-off to allow it,
  // from the beginnings of the last long steps: what lies before the present time is not taken again.
  const double t_failed = result_.state.t;
  has_history_ = false;
  for (std::size_t back = 0; back <= n_anchors_; ++back) {
    const Instant from = back == 0 ? Instant{result_.state, result_.v_dot}
                                   : anchors_[(next_anchor_ + kAnchors - back) % kAnchors];
    bool goes_on = true;
    if (!leap(from, goes_on)) continue;
    if (!goes_on) return false;
    if (result_.state.t - t_failed < 1e-7 * (options_.end_time - options_.start_time)) continue;
    ++result_.counts.hops;
    n_anchors_ = 0;
    integrator_->set_horizon(times_.next(result_.state.t).t);
    integrator_->start(result_.state, result_.v_dot);
    has_history_ = false;
    return result_.state.t < options_.end_time;
  }
  throw reason;
}

// A few explicit steps; false where not even one of them came beyond the present time.
bool Runner::leap(const Instant& from, bool& goes_on) {
  SolverOptions explicit_options = options_;
  explicit_options.method = "runge_kutta";
  explicit_options.method_is_open = false;
  // Steps that the implicit method took at order five or below are easy for this one; error control would
  // creep into the singular position instead of over it.
  explicit_options.fixed_step = std::max(0.5 * good_step_, 1.5 * (result_.state.t - from.state.t));
  explicit_options.max_step = 0.0;
  bool came_on = false;
  try {
    hopper_ = make_integrator(eq_, explicit_options);
    State s = from.state;
    Eigen::VectorXd v_dot = from.v_dot;
    // What Newton left of G v would grow like 1 / sigma.
    if (!start_again(s, v_dot)) return false;
    hopper_->start(s, v_dot);
    for (int k = 0; k < 4 && result_.state.t < options_.end_time; ++k) {
      const long passed = result_.time_events;
      if (k > 0) look_ahead();
      if (result_.time_events > passed) return true;
      const StepEnd end = hopper_->step(stop_.t);
      if (end.t_end <= result_.state.t) continue;
      came_on = true;
      goes_on = finish_step(end, *hopper_);
      // Behind an event the implicit method has started anew.
      if (!goes_on || !end.roots.empty() || result_.time_events > passed) return true;
    }
  } catch (const std::runtime_error&) {
    // As far as it came.
  }
  return came_on;
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
bool Runner::stop_at_contradiction(const StepEnd& end, Integrator& integrator) {
  if (!watch_.watches() || !contradicts(end.t_end, integrator)) return false;
  double agrees = result_.state.t, contradictory = end.t_end;
  for (int k = 0; k < 30; ++k) {
    const double middle = 0.5 * (agrees + contradictory);
    (contradicts(middle, integrator) ? contradictory : agrees) = middle;
  }
  contradicts(end.t_end, integrator);
  result_.stopped_because = watch_.complaint(end.t_end, agrees, RowWatch::allowed(options_.tolerance));
  if (agrees <= result_.state.t) return true;
  if (keeps_book_)
    enter_step(result_.state.t, agrees, agrees, integrator);
  else
    write_equilibria_until(agrees, agrees, integrator);
  integrator.interpolate(agrees, result_.state, result_.v_dot);
  return true;
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
  books_.settle();
  if (keeps_book_) books_.close(result_.state);
  start_anew();
}

bool Runner::finish_step(const StepEnd& end, Integrator& integrator) {
  if (stop_at_contradiction(end, integrator)) return false;
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
    books_.settle();
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

void Runner::resume(const Continuation& from) {
  if (options_.method_is_open && (from.method == "ida" || from.method == "radau")) {
    options_.method = from.method;
    integrator_ = make_integrator(eq_, options_);
  }
  if (from.method != options_.method)
    throw std::invalid_argument(
        fmt::format("the history is that of the integrator \"{}\", this run uses \"{}\"; take the same "
                    "method, or start from the state alone",
                    from.method, options_.method));
  const State& s = from.state;
  if (s.p.size() != n_.n_p || s.v.size() != n_.n_v || s.c.size() != n_.n_dyn ||
      s.lambda.size() != n_.n_lambda || s.a.size() != n_.n_alg ||
      static_cast<int>(s.root.size()) != n_.n_root)
    throw std::invalid_argument(
        "the state to go on from belongs to another mechanism: it has other numbers of states");
  if (from.v_dot.size() != 0 || keeps_book_) require_size(from.v_dot.size(), n_.n_v);
  const auto finite = [](const auto& x) {
    return std::ranges::all_of(x, [](double y) { return std::isfinite(y); });
  };
  for (const Eigen::VectorXd* x : {&s.p, &s.v, &s.c, &s.lambda, &s.a, &from.v_dot})
    if (!x->allFinite()) refuse_history();
  if (!std::isfinite(s.t) || !finite(from.history)) refuse_history();
  if (s.t < options_.start_time || s.t > options_.end_time)
    throw std::invalid_argument(fmt::format(
        "the state to go on from is that at t = {:.9g} s, and the run goes from {:.9g} to {:.9g} s: "
        "give the start_time of the run that was saved and a later end_time",
        s.t, options_.start_time, options_.end_time));
  const long next = next_row_at(s.t, from.next_row);
  result_.state = s;
  result_.v_dot = from.v_dot;
  History history(opened(from.history));
  books_.closer().remember(history);
  remember_own(history);
  integrator_->remember(history);
  method_watch_.take_counts(options_.method, integrator_->counts());
  if (!history.is_used_up())
    throw std::invalid_argument(
        "the integrator's history is longer than this mechanism needs: it was saved by another one; start "
        "from the states alone (--from-state)");
  books_.book().resume(from.energy, s.t);
  next_row_ = next;
  resumed_ = has_history_ = true;
}

void Runner::resume(const RunMemory& from) {
  resume(from.continuation);
  before_ = from;
  counts_at_once_ = integrator_->counts();
  result_.counts.hops = from.counts.hops;
  result_.events = from.events;
  good_step_ = from.good_step;
}

// The first row that was not given away at t, as the file says; throws where that cannot be.
long Runner::next_row_at(double t, long said) const {
  const double nearly = 1e-9 * options_.output_step + 1e-14 * std::abs(t);
  // A step may end an ulp before or behind a row.
  if (said >= 1 && said <= n_rows_ + 2 && row_time(said - 1) <= t + nearly && row_time(said) >= t - nearly)
    return said;
  long k =
      std::clamp(static_cast<long>((t - options_.start_time) / options_.output_step) - 1, 1L, n_rows_ + 1);
  while (row_time(k) <= t + nearly && row_time(k) > row_time(k - 1)) ++k;
  if (said == k + 1) return k;  // saved at an end beside the rows' grid, which gave a row of its own
  throw std::invalid_argument(
      fmt::format("the next row is said to be number {}, and after t = {:.9g} s it is number {}: the file "
                  "was changed, or "
                  "start_time or output_step are others than in the run that was saved",
                  said, t, k));
}

// The integrator's memory holds no counts: what it has counted since it took its history up is added.
StepCounts Runner::counts() const {
  StepCounts c = before_.counts;
  const StepCounts now = integrator_->counts();
  for (long StepCounts::*of :
       {&StepCounts::steps, &StepCounts::evaluations, &StepCounts::jacobians, &StepCounts::error_failures,
        &StepCounts::newton_failures, &StepCounts::restarts})
    c.*of += now.*of - counts_at_once_.*of;
  c.hops = result_.counts.hops;
  return c;
}

// What the run itself remembers beside its integrator.
void Runner::remember_own(History& history) {
  method_watch_.remember(history);
  for (Instant& anchor : anchors_) {
    history(anchor.state);
    history(anchor.v_dot);
  }
  long n = static_cast<long>(n_anchors_), next = static_cast<long>(next_anchor_);
  history(n);
  history(next);
  if (!history.reads()) return;
  require_between(n, 0, kAnchors);
  require_between(next, 0, kAnchors - 1);
  n_anchors_ = static_cast<std::size_t>(n);
  next_anchor_ = static_cast<std::size_t>(next);
  for (std::size_t back = 1; back <= n_anchors_; ++back) {
    const Instant& anchor = anchors_[(next_anchor_ + kAnchors - back) % kAnchors];
    require_sizes(anchor.state, n_);
    require_size(anchor.v_dot.size(), n_.n_v);
  }
}

// Nothing of the run changes by this: what the run gives away is closed in other places.
void Runner::hand_out_memory() {
  books_.settle();
  RunMemory m;
  History history;
  books_.closer().remember(history);
  remember_own(history);
  integrator_->remember(history);
  m.continuation = {options_.method,         result_.state, result_.v_dot,
                    books_.book().account(), next_row_,     sealed(history.values())};
  m.counts = counts();
  const Bookkeeper::Peaks& peaks = books_.peaks();
  m.largest_energy_error = std::max(before_.largest_energy_error, peaks.energy_error);
  m.peak_position_drift = std::max(before_.peak_position_drift, peaks.drift.position);
  m.peak_velocity_drift = std::max(before_.peak_velocity_drift, peaks.drift.velocity);
  m.good_step = good_step_;
  m.wall_time =
      before_.wall_time + std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  m.events = result_.events;
  remembering_.take(m);
}

// What a run gives away stands on its constraints; the histories are those of a run that goes on.
void Runner::remember() {
  books_.settle();
  Continuation& c = result_.continuation;
  History history;
  books_.closer().remember(history);
  remember_own(history);
  if (options_.end_time > options_.start_time) integrator_->remember(history);
  c.history = sealed(history.values());
  if (keeps_book_) {
    books_.close(result_.state);
    books_.closer().accelerate(result_.state, result_.v_dot);
  }
  c.method = options_.method;
  c.state = result_.state;
  c.v_dot = result_.v_dot;
  c.energy = books_.book().account();
  c.next_row = next_row_;
}

RunResult Runner::run() {
  begin_ = std::chrono::steady_clock::now();
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
      if (!resumed_ && keeps_book_) {
        integrator_->set_horizon(times_.next(result_.state.t).t);
        integrator_->start(result_.state, result_.v_dot);
      }
      while (step_once())
        if (has_history_ && remembering_.wanted && remembering_.wanted()) hand_out_memory();
      if (has_history_ && !result_.stopped_because.empty() && remembering_.take && remembering_.at_the_end)
        hand_out_memory();
    }
    result_.complete = result_.stopped_because.empty();
  } catch (const IntegrationError& e) {
    result_.stopped_because = with_rank_loss(eq_, result_.state, e.what());
  } catch (const AssemblyError& e) {
    result_.stopped_because = e.what();
  } catch (...) {
    books_.settle_what_can_be();  // rows before the trouble are worth keeping
    throw;
  }
  remember();
  result_.counts = counts();
  result_.method = options_.method;
  if (result_.method_changes.empty()) result_.method_hint = method_watch_.hint(options_.method);
  result_.energy = books_.book().account();
  const Bookkeeper::Peaks& peaks = books_.peaks();
  result_.largest_energy_error = std::max(before_.largest_energy_error, peaks.energy_error);
  result_.peak_position_drift = std::max(before_.peak_position_drift, peaks.drift.position);
  result_.peak_velocity_drift = std::max(before_.peak_velocity_drift, peaks.drift.velocity);
  result_.wall_time =
      before_.wall_time + std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  return result_;
}

}  // namespace

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

RunResult run(const Equations& eq, const State& start, const Eigen::VectorXd& v_dot,
              const SolverOptions& options, const RunCallbacks& callbacks, const Remembering& remembering) {
  return Runner(eq, start, v_dot, options, callbacks, remembering).run();
}

RunResult run(const Equations& eq, const RunMemory& from, const SolverOptions& options,
              const RunCallbacks& callbacks, const Remembering& remembering) {
  Runner runner(eq, from.continuation.state, from.continuation.v_dot, options, callbacks, remembering);
  runner.resume(from);
  return runner.run();
}

}  // namespace flexura::mbs
