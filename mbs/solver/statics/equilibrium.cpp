// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/statics/equilibrium.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/position/row_watch.hpp"

namespace flexura::mbs {
namespace {

// Undeforms all bodies whose law is not linear (ANCF beams); false where there are none.
bool straighten(const Mechanism& mechanism, State& s) {
  const std::vector<BodyDescription>& bodies = mechanism.description().bodies;
  bool any = false;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const int first = mechanism.modal_position(static_cast<int>(b));
    if (first < 0 || bodies[b].flexible->is_linear()) continue;
    s.p.segment(first, bodies[b].flexible->m()).setZero();
    any = true;
  }
  return any;
}

// Equilibria from `now` to that of the whole by steps of a tenth at most, halved where one is not found;
// set(options, part) brings in the part, from 0 to 1.  Empty where a step gets too short: `reached` tells how far they
// were followed.
template <class Set>
std::optional<StaticsReport> by_steps(const Mechanism& mechanism, State& now, StaticsOptions options,
                                      const Set& set, double* reached = nullptr) {
  constexpr double kLargest = 0.1, kLeast = 1e-3;
  StaticsReport report;
  const auto solve = [&](double part) {
    State next = now;
    set(options, part);
    try {
      const StaticsReport one = solve_statics(mechanism, next, options);
      report.iterations += one.iterations;
      report.force_residual = one.force_residual;
      report.constraint_residual = one.constraint_residual;
    } catch (const std::runtime_error&) {
      report.iterations += options.max_iterations;
      return false;
    }
    now = std::move(next);
    return true;
  };
  if (!solve(0.0)) return {};
  for (double done = 0.0, step = kLargest; done < 1.0;) {
    const double next = std::min(done + step, 1.0);
    if (solve(next)) {
      done = next;
      if (reached) *reached = done;
      step = std::min(2.0 * step, kLargest);
    } else if ((step *= 0.5) < kLeast) {
      return {};
    }
  }
  return report;
}

std::optional<StaticsReport> close_by_steps(const Mechanism& mechanism, State& s) {
  State now = s;
  if (mechanism.sizes().n_lambda == 0 || !straighten(mechanism, now)) return {};
  Eigen::VectorXd open(mechanism.sizes().n_lambda);
  mechanism.position_constraints(now, now.p, *mechanism.make_scratch(), open);
  double size = 0.0;
  for (int i = 0; i < mechanism.sizes().n_v; ++i) size = std::max(size, mechanism.velocity_scale(i));
  if (open.cwiseAbs().maxCoeff() < 1e-9 * size) return {};
  StaticsOptions options;
  options.max_iterations = 50;
  const auto report = by_steps(mechanism, now, options,
                               [&](StaticsOptions& o, double part) { o.opening = (1.0 - part) * open; });
  if (report) s = std::move(now);
  return report;
}

std::optional<StaticsReport> load_by_steps(const Mechanism& mechanism, State& s, double& reached) {
  State now = s;
  straighten(mechanism, now);
  Mechanism unloaded(mechanism.without_loads(now, *mechanism.make_scratch()).description);
  unloaded.drop_redundant(now, now.p);
  const Sizes all = mechanism.sizes(), n = unloaded.sizes();
  if (n.n_lambda != all.n_lambda || n.n_dyn != all.n_dyn || n.n_alg != all.n_alg || n.n_root != all.n_root)
    return {};
  now = s;
  StaticsOptions options;
  options.unloaded = &unloaded;
  options.max_iterations = 30;  // thin beams take 15 to 30 for a turn by 36 degrees
  options.stable = false;
  auto report = by_steps(
      mechanism, now, options, [](StaticsOptions& o, double part) { o.load = part; }, &reached);
  if (!report) return {};
  s = now;
  try {
    StaticsOptions downhill;
    downhill.max_iterations = 30;
    const StaticsReport last = solve_statics(mechanism, now, downhill);
    report->iterations += last.iterations;
    s = std::move(now);
  } catch (const std::runtime_error&) {
    report->stable = false;
  }
  return report;
}

StaticsReport search(const Mechanism& mechanism, State& s) {
  if (const auto report = close_by_steps(mechanism, s)) return *report;
  State now = s;
  double reached = 0.0;
  if (straighten(mechanism, now)) {
    // Loads that grow lead to an equilibrium that may be unstable: before that most of the steps downhill.
    StaticsOptions few;
    few.max_iterations = 300;
    try {
      now = s;
      const StaticsReport report = solve_statics(mechanism, now, few);
      s = std::move(now);
      return report;
    } catch (const std::runtime_error&) {
      if (const auto report = load_by_steps(mechanism, s, reached)) return *report;
    }
  }
  try {
    return solve_statics(mechanism, s);
  } catch (const AssemblyError&) {
    throw;
  } catch (const std::runtime_error&) {
    if (reached == 0.0) throw;
    throw std::runtime_error(
        fmt::format("no equilibrium found at t = {:.6g} s: brought in by steps, the loads are carried up to "
                    "{:.3g} % of them and no further; the mechanism gives way there, or its elements cannot "
                    "follow so much bending: give its beams more",
                    s.t, 100.0 * reached));
  }
}

}  // namespace

StaticsReport find_equilibrium(const Mechanism& mechanism, State& s) {
  RowWatch watch(mechanism);
  watch.begin(s);
  StaticsReport report = search(mechanism, s);
  // What followed from the other constraints where the search began need not do so where it ended.
  if (watch.look(s, RowWatch::Judge::positions).left_out > 1.0)
    throw std::runtime_error(
        fmt::format("the equilibrium found breaks constraints that were redundant at the start: {}",
                    watch.complaint_about_left_out(s.t)));
  return report;
}

}  // namespace flexura::mbs
