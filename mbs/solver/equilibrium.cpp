// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/equilibrium.hpp"

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace flexura::mbs {
namespace {

// With all ANCF beams undeformed; false where there are none.
bool straighten(const Mechanism& mechanism, State& s) {
  const std::vector<BodyDescription>& bodies = mechanism.description().bodies;
  bool any = false;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const int first = mechanism.modal_position(static_cast<int>(b));
    if (first < 0 || !bodies[b].flexible || bodies[b].flexible->is_modal()) continue;
    s.p.segment(first, bodies[b].flexible->m()).setZero();
    any = true;
  }
  return any;
}

std::optional<StaticsReport> close_by_steps(const Mechanism& mechanism, State& s) {
  State now = s;
  if (mechanism.sizes().n_lambda == 0 || !straighten(mechanism, now)) return {};
  Eigen::VectorXd open(mechanism.sizes().n_lambda);
  mechanism.position_constraints(now.t, now.p, *mechanism.make_scratch(), open);
  double size = 0.0;
  for (int i = 0; i < mechanism.sizes().n_v; ++i) size = std::max(size, mechanism.velocity_scale(i));
  if (open.cwiseAbs().maxCoeff() < 1e-9 * size) return {};
  StaticsReport report;
  StaticsOptions options;
  options.max_iterations = 50;
  double closed = 0.0, step = 0.1;
  const auto solve = [&](double part) {
    State next = now;
    options.opening = (1.0 - part) * open;
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
  while (closed < 1.0) {
    const double next = std::min(closed + step, 1.0);
    if (solve(next)) {
      closed = next;
      step = std::min(2.0 * step, 0.1);
    } else if ((step *= 0.5) < 1e-3) {
      return {};
    }
  }
  s = std::move(now);
  return report;
}

}  // namespace

StaticsReport find_equilibrium(const Mechanism& mechanism, State& s) {
  if (const auto report = close_by_steps(mechanism, s)) return *report;
  return solve_statics(mechanism, s);
}

}  // namespace flexura::mbs
