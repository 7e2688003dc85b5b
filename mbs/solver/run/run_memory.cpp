// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/run_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/algebra/remembered.hpp"
#include "mbs/solver/run/make_integrator.hpp"
#include "mbs/solver/run/runner.hpp"

namespace flexura::mbs {

namespace {

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

}  // namespace

void Runner::resume(const Continuation& from) {
  const auto may_go_on = [&](const IntegratorKind& kind) {
    return kind.is_for_all && from.method == kind.name;
  };
  // What stands still was left to kinematics, whatever the method.
  const bool stood = is_watched_ && std::ranges::any_of(integrator_kinds(), [&](const IntegratorKind& kind) {
                       return from.method == kind.name && !kind.integrates && kind.is_motion;
                     });
  if (stood || (options_.method_is_open && std::ranges::any_of(integrator_kinds(), may_go_on))) {
    options_.method = from.method;
    integrator_ = make_integrator(eq_, options_);
    is_watched_ = kind_of(options_).integrates;
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
  rows_.times().go_on_from(s.t, from.next_row);
  result_.state = s;
  result_.v_dot = from.v_dot;
  History history(opened(from.history));
  remember_rows(history);
  books_.closer().remember(history);
  remember_own(history);
  integrator_->remember(history);
  method_watch_.take_counts(options_.method, integrator_->counts());
  if (!history.is_used_up())
    throw std::invalid_argument(
        "the integrator's history is longer than this mechanism needs: it was saved by another one; start "
        "from the states alone (--from-state)");
  books_.book().resume(from.energy, s.t);
  resumed_ = has_history_ = true;
}

void Runner::resume(const RunMemory& from) {
  resume(from.continuation);
  before_ = from;
  counts_at_once_ = integrator_->counts();
  result_.counts.singular_crossings = from.counts.singular_crossings;
  result_.events = from.events;
  long_steps_.set_longest(from.good_step);
}

// The integrator's memory holds no counts: what it has counted since it took its history up is added.
StepCounts Runner::counts() const {
  StepCounts c = before_.counts;
  const StepCounts now = integrator_->counts();
  for (long StepCounts::*of :
       {&StepCounts::steps, &StepCounts::evaluations, &StepCounts::jacobians, &StepCounts::error_failures,
        &StepCounts::newton_failures, &StepCounts::restarts})
    c.*of += now.*of - counts_at_once_.*of;
  c.singular_crossings = result_.counts.singular_crossings;
  return c;
}

// Before all that holds multipliers.
void Runner::remember_rows(History& history) {
  if (!own_) return;
  history(chosen_at_);
  if (!history.reads() || chosen_at_.p.size() == 0) return;
  require_sizes(chosen_at_, n_);
  own_->choose_rows(chosen_at_, [] { return true; });
  contradictions_.change_rows(result_.state);
  books_.change_rows(result_.state);
}

// What the run itself remembers beside its integrator.
void Runner::remember_own(History& history) {
  method_watch_.remember(history);
  leaps_.remember(history);
  long_steps_.remember(history, n_);
}

// Nothing of the run changes by this: what the run gives away is closed in other places.
void Runner::hand_out_memory() {
  books_.drain();
  RunMemory m;
  History history;
  remember_rows(history);
  books_.closer().remember(history);
  remember_own(history);
  integrator_->remember(history);
  m.continuation = {options_.method,         result_.state,        result_.v_dot,
                    books_.book().account(), rows_.times().next(), sealed(history.values())};
  m.counts = counts();
  const Bookkeeper::Peaks& peaks = books_.peaks();
  m.largest_energy_error = std::max(before_.largest_energy_error, peaks.energy_error);
  m.peak_position_drift = std::max(before_.peak_position_drift, peaks.drift.position);
  m.peak_velocity_drift = std::max(before_.peak_velocity_drift, peaks.drift.velocity);
  m.good_step = long_steps_.longest();
  m.wall_time =
      before_.wall_time + std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  m.events = result_.events;
  remembering_.take(m);
}

// What a run gives away stands on its constraints; the histories are those of a run that goes on.
void Runner::remember() {
  books_.drain();
  Continuation& c = result_.continuation;
  History history;
  remember_rows(history);
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
  c.next_row = rows_.times().next();
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
