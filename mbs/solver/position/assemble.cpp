// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/assemble.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/saddle.hpp"
#include "mbs/solver/position/closing.hpp"
#include "mbs/solver/position/position_solver.hpp"

namespace flexura::mbs {

namespace {

// "\"loop.x\" (0.012 m), \"loop.axis_y\" (-0.003 rad)": the worst rows first, three at most, `per` second.
std::string worst_rows(const Equations& eq, const Eigen::VectorXd& residual, const Eigen::VectorXd& allowed,
                       const ConstraintSizes& sizes, const char* per = "") {
  std::vector<int> order(residual.size());
  std::iota(order.begin(), order.end(), 0);
  const auto open = [&](int k) { return std::abs(residual(k)) / sizes.size(k); };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return open(a) > open(b); });
  std::string text;
  for (std::size_t k = 0; k < std::min<std::size_t>(3, order.size()); ++k) {
    if (k > 0 && std::abs(residual(order[k])) <= allowed(order[k])) break;
    text += fmt::format("{}\"{}\" ({:.6g} {}{})", k == 0 ? "" : ", ", eq.name_of_constraint(order[k]),
                        residual(order[k]), sizes.is_length[order[k]] ? "m" : "rad", per);
  }
  return text;
}

std::string names_of(const Equations& eq, const std::vector<bool>& mask) {
  std::string text;
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (mask[i])
      text += fmt::format("{}\"{}\"", text.empty() ? "" : ", ", eq.name_of_velocity(static_cast<int>(i)));
  return text;
}

// By the coordinates that these velocities change, where each changes one alone: "B.angle", not "B.speed".
std::string names_of_positions(const Equations& eq, const Eigen::VectorXd& p, const std::vector<bool>& mask) {
  std::string text;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (!mask[i]) continue;
    const int k = static_cast<int>(i);
    Eigen::VectorXd moved(p.size());
    eq.retract(p, 1e-3 * Eigen::VectorXd::Unit(static_cast<Eigen::Index>(mask.size()), k), moved);
    int changed = 0, which = 0;
    for (int j = 0; j < p.size(); ++j)
      if (moved(j) != p(j)) ++changed, which = j;
    text += fmt::format("{}\"{}\"", text.empty() ? "" : ", ",
                        changed == 1 ? eq.name_of_position(which) : eq.name_of_velocity(k));
  }
  return text;
}

bool any(const std::vector<bool>& mask) {
  return std::find(mask.begin(), mask.end(), true) != mask.end();
}

// How freely each coordinate moves: held ones not at all, prescribed ones by the factor given.
Eigen::VectorXd freedoms(int n_v, const ClosingOptions& options, double of_prescribed) {
  Eigen::VectorXd free = Eigen::VectorXd::Ones(n_v);
  for (int i = 0; i < n_v; ++i) {
    if (!options.keep.empty() && options.keep[i]) free(i) = of_prescribed;
    if (!options.hold.empty() && options.hold[i]) free(i) = 0.0;
  }
  return free;
}

// Of a prescribed coordinate that has to move: small enough that the others come first, large enough that G
// keeps its rank in double precision (the square counts).
constexpr double kReluctant = 1e-2;

}  // namespace

Closing close_positions(const Equations& eq, State& s, const ClosingOptions& options) {
  Closing out;
  out.closed = true;
  AssembleReport& report = out.report;
  const Eigen::VectorXd start = s.p;
  const int n_v = eq.sizes().n_v;
  Eigen::VectorXd large = options.large;
  if (large.size() != n_v) {
    large.resize(n_v);
    for (int i = 0; i < n_v; ++i) large(i) = eq.velocity_scale(i);
  }
  // The attempt that left the loops open the least.
  struct Nearest {
    double openness = std::numeric_limits<double>::infinity();
    bool acceptable = false, kept = true;
    Eigen::VectorXd p, g;
    std::string worst;
    double change = 0.0;
    std::string out_of_reach;
  } nearest;
  const auto attempt = [&](const Eigen::VectorXd& free, double nudge, bool kept, double pattern = 0.0) {
    s.p = start;
    if (nudge > 0.0) {
      // At a stretched-out start the constraints' gradients can be blind to the way out; a small push shows
      // it.
      Eigen::VectorXd d = Eigen::VectorXd::Zero(n_v);
      int k = 0;  // of those that move: the push, and the branch it leads to, is that of the rigid mechanism
      for (int i = 0; i < n_v; ++i)
        if (free(i) > 0.0) d(i) = nudge * large(i) * std::cos((2.4 + pattern) * k++ + 0.7 + pattern);
      Eigen::VectorXd moved(start.size());
      eq.retract(start, d, moved);
      s.p = moved;
    }
    PositionSolver solver(eq, s, free, large);
    const bool solved = solver.solve(s.p, options.max_iterations);
    report.iterations += solver.iterations();
    report.position_change = solver.change();
    report.position_residual = solver.residual().size() > 0 ? solver.residual().cwiseAbs().maxCoeff() : 0.0;
    out.to_round_off = solver.is_closed();
    if (solved && nudge > 0.0)
      report.notes.push_back(fmt::format(
          "the start values lead to no closed loops of themselves (they are stretched out, or far off); a "
          "push of {:.2g} rad or lengths of the mechanism found the branch that the mechanism stands on: "
          "give "
          "values near the one that is meant",
          nudge));
    // A prescribed value moves only for a loop that closes better by it, not for round-off; parts that do not fit
    // stay where they were put unless they fit far better elsewhere.
    const double better = nearest.acceptable ? 0.01 : kept == nearest.kept ? 1.0 : 0.5;
    // The first is kept whatever it is: a row without direction (a distance from a point to itself) is open beyond measure.
    if (!solved && (nearest.p.size() == 0 || solver.openness() < better * nearest.openness))
      nearest = {solver.openness(),
                 solver.nearly_closed(),
                 kept,
                 s.p,
                 solver.residual(),
                 worst_rows(eq, solver.residual(), solver.allowed(), solver.sizes()),
                 solver.change(),
                 solver.rows_out_of_reach()};
    return solved;
  };
  constexpr double kNudges[] = {0.0, 1e-2, 1e-1};
  const Eigen::VectorXd keeping = freedoms(n_v, options, 0.0);
  for (const double nudge : kNudges)
    if (attempt(keeping, nudge, true)) return out;
  const auto say_moved = [&] {
    report.positions_kept = false;
    report.notes.push_back(
        fmt::format("the prescribed initial positions {} contradict the constraints and were moved to "
                    "close the loops",
                    names_of_positions(eq, start, options.keep)));
  };
  // Each start costs up to max_iterations factorisations: mechanisms of many coordinates do without.
  const auto far = [&](const Eigen::VectorXd& free, bool kept) {
    if (!options.search_far || nearest.acceptable || n_v > 150) return false;
    for (const double nudge : {0.3, 0.6, 1.2, 2.4})
      for (const double pattern : {0.0, 1.9, 3.1, 4.3})
        if (attempt(free, nudge, kept, pattern)) return true;
    return false;
  };
  if (far(keeping, true)) return out;
  if (any(options.keep)) {
    const Eigen::VectorXd reluctant = freedoms(n_v, options, kReluctant);
    for (const double nudge : kNudges)
      if (attempt(reluctant, nudge, false)) {
        say_moved();
        return out;
      }
    if (far(reluctant, false)) {
      say_moved();
      return out;
    }
  }
  if (nearest.acceptable) {
    // Parts that do not fit exactly, like a loop around an axis whose markers stand a nanometre apart along
    // it.
    s.p = nearest.p;
    report.position_change = nearest.change;
    report.position_residual = nearest.g.cwiseAbs().maxCoeff();
    out.to_round_off = false;
    if (!nearest.kept) say_moved();
    report.notes.push_back(
        fmt::format("the loops close but for {}, taken as parts that do not fit exactly", nearest.worst));
    return out;
  }
  // Newton's method came to rest where its own measure is least: the gap itself may be less beside it, and what is given
  // is no reason to show a wider one.
  if (n_v > 0 && nearest.p.size() > 0 && nearest.out_of_reach.empty()) {
    PositionSolver solver(eq, s, freedoms(n_v, options, 1.0), large, Measure::gaps);
    Eigen::VectorXd p = nearest.p;
    solver.approach(p, options.max_iterations);
    report.iterations += solver.iterations();
    const auto gap = [&](const Eigen::VectorXd& g) { return g.cwiseQuotient(solver.sizes().size).norm(); };
    if (gap(solver.residual()) < gap(nearest.g)) {
      nearest.p = p;
      nearest.g = solver.residual();
      nearest.worst = worst_rows(eq, nearest.g, solver.allowed(), solver.sizes());
    }
  }
  s.p = start;
  out.closed = out.to_round_off = false;
  out.p = nearest.p;
  out.g = nearest.g;
  out.worst = nearest.worst;
  out.out_of_reach = nearest.out_of_reach;
  return out;
}

AssembleReport assemble_positions(const Equations& eq, State& s, const AssembleOptions& options) {
  const Closing closing = close_positions(eq, s, {options.keep_position, {}, false, options.max_iterations});
  if (closing.closed) return closing.report;
  throw AssemblyError(
      fmt::format("the mechanism cannot be assembled at t = {:.6g} s: {}", s.t, why_open(closing)));
}

std::string why_open(const Closing& closing) {
  if (!closing.out_of_reach.empty())
    return fmt::format(
        "{} cannot be met: nothing can move that changes it; mend the markers and lengths of the parts that "
        "it "
        "joins, or give them a joint that lets them move",
        closing.out_of_reach);
  return fmt::format(
      "the constraints {} cannot be closed; check the markers, lengths and initial positions of the parts "
      "that "
      "they join",
      closing.worst);
}

void assemble_velocities(const Equations& eq, State& s, const AssembleOptions& options,
                         AssembleReport& report) {
  const Sizes n = eq.sizes();
  if (n.n_lambda == 0 || n.n_v == 0) return;
  auto scratch = eq.make_scratch();
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n.n_v, n.n_v), G = Eigen::MatrixXd::Zero(n.n_lambda, n.n_v);
  Eigen::VectorXd g_dot = Eigen::VectorXd::Zero(n.n_lambda), g_t = g_dot, delta, impulse;
  eq.mass_matrix(s.p, *scratch, M);
  eq.constraint_matrix(s, s.p, *scratch, G);
  eq.velocity_constraints(s, s.p, Eigen::VectorXd::Zero(n.n_v), *scratch, g_t);
  const Eigen::VectorXd start = s.v;
  const ConstraintSizes sizes = eq.constraint_sizes(s, s.p, *scratch);
  Eigen::VectorXd typical(n.n_v);
  for (int i = 0; i < n.n_v; ++i) typical(i) = eq.velocity_scale(i);
  SaddleSolver saddle;
  Eigen::Array<bool, Eigen::Dynamic, 1> open;
  auto attempt = [&](const std::vector<bool>& keep) {
    std::vector<bool> is_free(keep);
    is_free.flip();
    saddle.factor(eq, M, G, is_free);
    s.v = start;
    for (int pass = 0; pass < 2; ++pass) {  // the second refines
      eq.velocity_constraints(s, s.p, s.v, *scratch, g_dot);
      g_dot = -g_dot;
      saddle.solve(Eigen::VectorXd::Zero(n.n_v), g_dot, delta, impulse);
      s.v += delta;
    }
    eq.velocity_constraints(s, s.p, s.v, *scratch, g_dot);
    report.velocity_residual = g_dot.cwiseAbs().maxCoeff();
    // What velocities of this size may leave by round-off of a matrix with condition 1e6 or better; of a row that only
    // deformations move, which stay at rest, those of the rows beside it.
    const double beside = g_t.cwiseQuotient(sizes.size).lpNorm<Eigen::Infinity>();
    // Of mechanisms at rest 1e-12, in units of the row: factors of 1e-13 make speeds of 1 that small.
    const Eigen::VectorXd allowed =
        1e-9 * (G.cwiseAbs() * (start.cwiseAbs() + s.v.cwiseAbs()) + g_t.cwiseAbs() + beside * sizes.size) +
        1e-12 * sizes.size.cwiseMin(1.0);
    // Where kept velocities leave only coordinates that the rows do not see (but for round-off of G) these would
    // have to run without bound.
    constexpr double kRunaway = 1e8;
    const double wanted = std::max({start.cwiseQuotient(typical).lpNorm<Eigen::Infinity>(),
                                    g_t.cwiseQuotient(sizes.size).lpNorm<Eigen::Infinity>(), 1e-300});
    open = g_dot.cwiseAbs().array() > allowed.array();
    return !open.any() && s.v.cwiseQuotient(typical).lpNorm<Eigen::Infinity>() <= kRunaway * wanted;
  };
  if (attempt(options.keep_velocity)) return;
  // First those alone that the rows in question see, as where a drive contradicts the speeds of a whole state.
  std::vector<bool> beside = options.keep_velocity;
  for (std::size_t i = 0; i < beside.size(); ++i)
    for (int k = 0; k < n.n_lambda; ++k)
      if (open(k) && G(k, static_cast<Eigen::Index>(i)) != 0.0) beside[i] = false;
  if (any(options.keep_velocity) && (attempt(beside) || attempt({}))) {
    report.velocities_kept = false;
    // A whole state prescribes all of them, and a drive changes its own alone.
    constexpr double kRoundOff = 1e-9;
    const double largest = s.v.cwiseQuotient(typical).lpNorm<Eigen::Infinity>();
    std::vector<bool> changed = options.keep_velocity;
    for (int i = 0; i < n.n_v; ++i)
      if (std::abs(s.v(i) - start(i)) <= kRoundOff * largest * typical(i)) changed[i] = false;
    report.notes.push_back(
        fmt::format("the prescribed initial velocities {} contradict the constraints and were changed",
                    names_of(eq, changed)));
    return;
  }
  throw AssemblyError(
      fmt::format("the initial velocities cannot be made consistent at t = {:.6g} s: the constraints {} want "
                  "motions that "
                  "exclude each other; check driven joints and the loops that they move",
                  s.t, worst_rows(eq, g_dot, Eigen::VectorXd::Zero(n.n_lambda), sizes, "/s")));
}

AssembleReport assemble(const Equations& eq, State& s, Eigen::VectorXd& v_dot,
                        const AssembleOptions& options) {
  AssembleReport report = assemble_positions(eq, s, options);
  assemble_velocities(eq, s, options, report);
  AccelerationSolver accelerations(eq);
  accelerations.solve(s, v_dot);
  report.constraint_rank = accelerations.constraint_rank();
  return report;
}

}  // namespace flexura::mbs
