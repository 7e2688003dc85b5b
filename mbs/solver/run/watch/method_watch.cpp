// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/watch/method_watch.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/solver/algebra/remembered.hpp"
#include "mbs/solver/run/make_integrator.hpp"

namespace flexura::mbs {

namespace {

constexpr long kFirstLook = 1000, kNextLook = 4;
// Where steps are dear: a run of 500 of them lasts long enough for a word.
constexpr long kFirstLookIfLarge = 250;
constexpr double kLarge = 100.0;
// Part of the work done that a look may cost, for a method to change to and for one only to be named.
constexpr double kShare = 0.04, kShareToName = 0.015;
// What is left of the run must be worth a look.
constexpr double kWorthwhile = 0.25;
// A method is changed, and another one named, from these factors on: the count of work is good to two.
constexpr double kChange = 3.0, kName = 5.0;
// Events that are counted, and steps between two of them from which on IDA is at its full order most of the time: from order
// one it takes some 20 steps to get there. Radau takes four a millisecond of a sampled controller where IDA takes 20, half
// the time.
constexpr long kEvents = 20, kStepsBetween = 40;

}  // namespace

MethodWatch::MethodWatch(const Equations& eq, const SolverOptions& options)
    : eq_(eq),
      options_(options),
      n_(eq.sizes().n_v + 2.0 * eq.sizes().n_lambda),
      first_look_(n_ > kLarge ? kFirstLookIfLarge : kFirstLook),
      next_look_(first_look_),
      half_way_(first_look_ / 2),
      t_half_(options.start_time) {
  for (const IntegratorKind& kind : integrator_kinds())
    if (kind.integrates) others_.emplace_back(kind.name);
  work_of_others_.assign(others_.size(), 0.0);
}

// In evaluations of the residual, some 500 n operations each: a dense factorisation takes n^3 / 3, of complex
// numbers four times as much; derivatives as much as six evaluations.
double MethodWatch::work(const std::string& method, const StepCounts& c) const {
  const double factor = n_ * n_ / 1500.0, evaluations = static_cast<double>(c.evaluations),
               jacobians = static_cast<double>(c.jacobians);
  const IntegratorKind& kind = kind_of(method);
  const double of_evaluation = eq_.sizes().n_lambda > 0
                                   ? kind.constrained_evaluation + kind.constrained_factor * factor
                                   : kind.evaluation;
  return of_evaluation * evaluations + jacobians * (6.0 + kind.matrix * factor);
}

bool MethodWatch::step(const std::string& method, double t, const StepCounts& counts) {
  const double now = work(method, counts);
  work_ += now - counted_;
  counted_ = now;
  if (++steps_ == half_way_) {
    t_half_ = t;
    work_half_ = work_;
  }
  if (steps_ < next_look_) return false;
  next_look_ = kNextLook * steps_;
  half_way_ = (steps_ + next_look_) / 2;
  pace_ = work_ > work_half_ ? (t - t_half_) / (work_ - work_half_) : 0.0;
  return options_.end_time - t > kWorthwhile * pace_ * work_;
}

double MethodWatch::pace_of(const std::string& method, const State& s, const Eigen::VectorXd& v_dot,
                            double budget, double until) const {
  SolverOptions options = options_;
  options.method = method;
  options.fixed_step = options.first_step = 0.0;
  double t = s.t, t_half = s.t, half = 0.0, spent = 0.0;
  try {
    const std::unique_ptr<Integrator> integrator = make_integrator(eq_, options);
    integrator->start(s, v_dot);
    while (spent < budget && t < until) {
      const StepEnd end = integrator->step(until);
      t = end.t_end;
      spent = work(method, integrator->counts());
      if (half == 0.0 && spent > 0.5 * budget && spent < budget) {
        t_half = t;
        half = spent;
      }
      if (!end.roots.empty()) break;
    }
  } catch (const std::exception&) {
    return 0.0;
  }
  return spent > half ? (t - t_half) / (spent - half) : 0.0;
}

void MethodWatch::restart(double t) {
  if (restarts_ == kEvents) {
    between_events_ = (t - t_first_) / kEvents;
    is_ruled_by_events_ = steps_ - steps_at_first_ < kEvents * kStepsBetween;
    restarts_ = 0;
  }
  if (restarts_++ > 0) return;
  t_first_ = t;
  steps_at_first_ = steps_;
}

std::string MethodWatch::for_events(const std::string& method) {
  // What needs many steps for its order has those that one step of order five counts for.
  const auto is_of_many = [](const std::string& name) { return kind_of(name).steps_of_error > 1; };
  if (!is_ruled_by_events_ || !options_.method_is_open || !is_of_many(method)) return {};
  is_ruled_by_events_ = false;
  for (const std::string& other : others_)
    if (kind_of(other).is_for_all && !is_of_many(other)) return other;
  return {};
}

std::string MethodWatch::look(const std::string& method, const State& s, const Eigen::VectorXd& v_dot,
                              double until) {
  if (!(pace_ > 0.0)) return {};
  const double since = work_ - work_looked_;
  work_looked_ = work_;
  work_compared_ += since;
  std::string best;
  double best_gain = kChange;
  for (std::size_t i = 0; i < others_.size(); ++i) {
    const std::string& other = others_[i];
    const bool may_take_over = options_.method_is_open && kind_of(other).is_for_all;
    double gain = 1.0;
    // For the methods that are only named the first look would be too short.
    if (other != method && (may_take_over || kind_of(other).is_for_all || steps_ > first_look_))
      gain = pace_of(other, s, v_dot, (may_take_over ? kShare : kShareToName) * work_, until) / pace_;
    work_of_others_[i] += since / std::max(gain, 1e-3);
    if (may_take_over && other != method && gain > best_gain) {
      best = other;
      best_gain = gain;
    }
  }
  last_gain_ = best_gain;
  return best;
}

std::string MethodWatch::after_failure(const std::string& method, const State& s,
                                       const Eigen::VectorXd& v_dot) {
  constexpr double kTrial = 500.0;  // evaluations: enough for a few steps of any method
  if (!options_.method_is_open) return {};
  for (const std::string& other : others_)
    if (kind_of(other).is_for_all && other != method &&
        pace_of(other, s, v_dot, kTrial, options_.end_time) > 0.0)
      return other;
  return {};
}

void MethodWatch::change() {
  steps_ = 0;
  next_look_ = first_look_;
  half_way_ = first_look_ / 2;
  work_ = counted_ = work_half_ = work_looked_ = 0.0;
  restarts_ = steps_at_first_ = 0;
  is_ruled_by_events_ = false;
}

std::string MethodWatch::hint(const std::string& method) const {
  if (!(work_compared_ > 0.0)) return {};
  const auto best = std::ranges::min_element(work_of_others_);
  const std::string& other = others_[static_cast<std::size_t>(best - work_of_others_.begin())];
  const double factor = work_compared_ / *best;
  if (other == method || factor < kName) return {};
  return fmt::format("{} would take about 1/{:.0f} of the work that {} takes here: --set solver.method={}{}",
                     other, factor, method, other,
                     options_.fixed_step > 0.0 ? " --set solver.fixed_step=0" : "");
}

void MethodWatch::remember(History& history) {
  for (long* x : {&steps_, &next_look_, &half_way_, &restarts_, &steps_at_first_}) history(*x);
  for (double* x : {&work_, &t_half_, &work_half_, &work_looked_, &work_compared_, &t_first_}) history(*x);
  for (double& x : work_of_others_) history(x);
  if (!history.reads()) return;
  for (const long x : {steps_, next_look_, half_way_, restarts_, steps_at_first_})
    require_between(x, 0, 1L << 48);
}

}  // namespace flexura::mbs
