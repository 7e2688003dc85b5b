// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/algebra/finite.hpp"
#include "mbs/solver/position/dead_point.hpp"
#include "mbs/solver/run/make_integrator.hpp"
#include "mbs/solver/run/runner.hpp"
#include "mbs/solver/run/watch/standstill.hpp"

/// Where an integrator does not come on, or another would come on faster: steps across singular positions, where constraints
/// lose rank, and changes of the method.
namespace flexura::mbs {

namespace {

constexpr int kMostCrossings = 1000;
constexpr double kClosesThere = 1e-10;
/// Of the run: a tight tolerance creeps into the singular position for so long that no long step is left to go by.
constexpr double kLeastLeap = 1e-5;
constexpr std::size_t kMostChanges = 20;

// The velocity that changes most, in its usual size.
std::string fastest(const Equations& eq, const Eigen::VectorXd& v_dot) {
  int which = -1;
  double most = 0.0;
  for (int i = 0; i < v_dot.size(); ++i)
    if (const double rate = std::abs(v_dot(i)) / eq.velocity_scale(i); rate > most) {
      most = rate;
      which = i;
    }
  return which < 0 ? "a state of an element" : "\"" + eq.name_of_velocity(which) + "\"";
}

}  // namespace

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
  const KnownTimes::Stop next = times_.next(s.t);
  const double until = next.is_event ? std::min(next.t, options_.end_time) : options_.end_time;
  const std::string method = method_watch_.look(options_.method, s, v_dot, until);
  if (!method.empty())
    change_method(method, fmt::format("it is about {:.0f} times as fast there", method_watch_.last_gain()));
}

void Runner::prefer_method_for_events() {
  const std::string method = method_watch_.for_events(options_.method);
  if (method.empty() || result_.method_changes.size() >= kMostChanges) return;
  change_method(
      method,
      fmt::format("events follow one another every {:.3g} s, where it takes fewer steps from one to the next",
                  method_watch_.between_events()));
}

// The windows of steps that just crept: soon where rows lose rank there, else when nothing has changed for a while.
void Runner::refuse_creeping() {
  // Steps shorten without end where a motion grows without bound.
  books_.drain();
  if (const std::string growth = books_.suspected_growth(); !growth.empty()) throw IntegrationError(growth);
  constexpr int kEnough = 16;
  const State& s = result_.state;
  const int windows = pace_watch_.windows();
  const std::string creeps =
      fmt::format("{} creeps at t = {:.9g} s with steps of {:.2g} s, and would need {:.1g} more of them",
                  options_.method, s.t, pace_watch_.mean_step(), pace_watch_.steps_left(s.t));
  const bool looks = (windows & (windows - 1)) == 0;
  const bool is_lock = looks && with_rank_loss(eq_, s, creeps) != creeps;
  if (!is_lock && windows < kEnough) return;
  throw IntegrationError(fmt::format(
      "{}: something there is stiffer or faster by far than the run is long ({} changes fastest); give it "
      "a more compliant law or more damping, loosen the tolerance, or take another method",
      creeps, fastest(eq_, result_.v_dot)));
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
  is_watched_ = kind_of(options_).integrates;
  method_watch_.change();
  pace_watch_.change(result_.state.t);
  start_again(result_.state, result_.v_dot);
  start_integrator();
}

bool Runner::cross_singularity(const IntegrationError& reason) {
  // Near a dead point, where constraints lose rank for an instant, round-off of g is amplified by 1 / sigma^2
  // and no method with an error control gets near to it at a tight tolerance however short its step.  Accelerations are
  // finite there: a few explicit steps of fixed size lead across.
  if (!kind_of(options_).integrates || n_.n_lambda == 0 ||
      result_.counts.singular_crossings >= kMostCrossings)
    throw reason;
  bool goes_on = true;
  try {
    if (leap_across(1e-7 * (options_.end_time - options_.start_time), goes_on)) return goes_on;
  } catch (const NonFiniteError&) {
    // Beyond where the mechanism locks there is nothing to land on: that it locks is what there is to say.
    throw reason;
  }
  throw reason;
}

// From where the run stands, or, where that is too near to the singular position for round-off to allow it, from the
// beginnings of the last long steps: what lies before the present time is not taken again. False where no leap comes on by
// `least_way` (s); `goes_on` is whether the run does.
bool Runner::leap_across(double least_way, bool& goes_on) {
  const double t_failed = result_.state.t;
  has_history_ = false;
  for (std::size_t back = 0; back <= long_steps_.n_beginnings(); ++back) {
    const Instant from = back == 0 ? Instant{result_.state, result_.v_dot} : long_steps_.beginning(back);
    goes_on = true;
    if (!leap(from, goes_on)) continue;
    if (!goes_on) return true;
    if (result_.state.t - t_failed < least_way) continue;
    ++result_.counts.singular_crossings;
    long_steps_.forget_beginnings();
    start_integrator();
    goes_on = result_.state.t < options_.end_time;
    return true;
  }
  return false;
}

// Rows that follow from others (a Bennett linkage closes with two of the five of a hinge) follow from those that were kept at
// the start only where these are independent: for an instant the mechanism may be held by the rows left out alone. What they
// are open by there is no contradiction, and explicit steps lead across.
bool Runner::pass_rank_loss(bool& goes_on) {
  constexpr double kNearlyLost = 0.05;  // independence of the kept rows, 1 where they are orthogonal
  if (!kind_of(options_).is_implicit || n_.n_lambda == 0 ||
      result_.counts.singular_crossings >= kMostCrossings)
    return false;
  if (independence_of_rows(eq_, result_.state, *scratch_, nullptr) > kNearlyLost) return false;
  try {
    return leap_across(0.0, goes_on);
  } catch (const std::runtime_error&) {
    return false;
  }
}

// Rows that follow from others do so wherever these are independent. Where they come near to depending on each other (bar and
// crank of a Scott-Russell linkage in one line), rows that were left out hold what they no longer do: where the independence is
// below `near`, and another choice is `gain` times as good. False where there is none.
bool Runner::choose_rows_anew(double near, double gain) {
  if (!own_ || !keeps_book_) return false;
  State& s = result_.state;
  const double now = hold_of_rows(eq_, s, *scratch_);
  if (now > near) {
    tried_at_ = 1.0;
    return false;
  }
  // Beside a dead point of all rows there is nothing to choose, and a look at each step would be one too many.
  if (near < 1.0 && now > 0.5 * tried_at_) return false;
  books_.drain();
  const auto is_better = [&] { return hold_of_rows(eq_, s, *scratch_) > gain * now; };
  if (!own_->choose_rows(s, is_better)) {
    tried_at_ = now;
    return false;
  }
  chosen_at_ = s;
  tried_at_ = 1.0;
  contradictions_.change_rows(s);
  books_.change_rows(s);
  books_.close(s);
  before_.counts = counts();
  counts_at_once_ = {};
  integrator_ = make_integrator(eq_, options_);
  start_anew();
  return true;
}

// A few explicit steps; false where not even one of them came beyond the present time.
bool Runner::leap(const Instant& from, bool& goes_on) {
  SolverOptions explicit_options = options_;
  explicit_options.method = "runge_kutta";
  explicit_options.method_is_open = false;
  // Steps that the implicit method took at order five or below are easy for this one; error control would
  // creep into the singular position instead of over it.
  explicit_options.fixed_step = std::max({0.5 * long_steps_.longest(), 1.5 * (result_.state.t - from.state.t),
                                          kLeastLeap * (options_.end_time - options_.start_time)});
  explicit_options.max_step = 0.0;
  // Loops are not closed to the last digits there.
  explicit_options.tolerance = std::max(options_.tolerance, kClosesThere);
  hopper_ = make_integrator(eq_, explicit_options);
  State s = from.state;
  Eigen::VectorXd v_dot = from.v_dot;
  // What Newton left of G v would grow like 1 / sigma.
  if (!start_again(s, v_dot)) return false;
  // What rows and events have to say is said; only the steps themselves may fail.
  const auto goes = [](const auto& what) {
    try {
      what();
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  };
  if (!goes([&] { hopper_->start(s, v_dot); })) return false;
  bool came_on = false;
  for (int k = 0; k < 4 && is_on_its_way(); ++k) {
    const long passed = result_.time_events;
    if (k > 0) look_ahead();
    if (result_.time_events > passed) return true;
    StepEnd end;
    if (!goes([&] { end = hopper_->step(stop_.t); })) return came_on;
    if (end.t_end <= result_.state.t) continue;
    came_on = true;
    goes_on = finish_step(end, *hopper_);
    // Behind an event the implicit method has started anew.
    if (!goes_on || !end.roots.empty() || result_.time_events > passed) return true;
  }
  return came_on;
}

// Errors of algebraic states do not steer steps, so an integrator may come past where their equations lose their solution:
// the run ends there, and rows until then are kept.
bool Runner::stops_without_algebraic(const StepEnd& end, Integrator& integrator) {
  if (n_.n_alg == 0 || eq_.algebraic_is_coupled()) return false;
  State s;
  Eigen::VectorXd v_dot, last = result_.state.a;
  std::string complaint;
  const auto is_solved = [&](double t) {
    integrator.interpolate(t, s, v_dot);
    for (const bool from_last : {false, true}) try {
        if (from_last) s.a = last;
        accelerations_.solve_algebraic(s);
        if (!s.a.allFinite()) continue;
        last = s.a;
        return true;
      } catch (const std::runtime_error& e) {
        complaint = e.what();
      }
    return false;
  };
  if (is_solved(end.t_end)) return false;
  double solved = result_.state.t, lost = end.t_end;
  for (double middle; (middle = 0.5 * (solved + lost)) > solved && middle < lost;)
    (is_solved(middle) ? solved : lost) = middle;
  is_solved(lost);
  result_.stopped_because = complaint;
  if (solved <= result_.state.t) return true;
  rows_.enter_step(result_.state.t, solved, solved, integrator);
  integrator.interpolate(solved, result_.state, result_.v_dot);
  result_.state.a = last;
  return true;
}

}  // namespace flexura::mbs
