// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/statics/statics.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/algebra/downhill.hpp"
#include "mbs/solver/algebra/finite.hpp"
#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/algebra/tangents.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/statics/following_states.hpp"

namespace flexura::mbs {

namespace {

// Given moments turn K unsymmetric: its symmetric part may be indefinite where every motion returns.
bool returns(const Eigen::MatrixXd& H) {
  if (H.cols() == 0 || (H - H.transpose()).norm() < 1e-12 * H.norm()) return false;
  const Eigen::VectorXcd mu = Eigen::EigenSolver<Eigen::MatrixXd>(H, false).eigenvalues();
  return mu.real().minCoeff() > 1e-12 * mu.cwiseAbs().maxCoeff();
}

// Which of the rows of G forbid what J x = 0 leaves free.
std::vector<int> rows_of_free_places(const Eigen::MatrixXd& J, const Eigen::MatrixXd& G,
                                     const std::vector<int>& which) {
  // Rows, then columns of one size: neither stiffness nor the gain of a drive is to decide.
  const auto inverse = [](const Eigen::VectorXd& norms) -> Eigen::VectorXd {
    return (norms.array() > 0.0).select(norms.cwiseInverse(), 1.0);
  };
  Eigen::MatrixXd E = inverse(J.rowwise().norm()).asDiagonal() * J;
  const Eigen::VectorXd of_columns = inverse(E.colwise().norm());
  E = E * of_columns.asDiagonal();
  Eigen::FullPivLU<Eigen::MatrixXd> lu(E);
  lu.setThreshold(1e-12);
  if (lu.isInvertible()) return {};
  const Eigen::MatrixXd free = lu.kernel().colwise().normalized().topRows(G.cols());
  const Eigen::MatrixXd moves = G * of_columns.head(G.cols()).asDiagonal() * free;
  const Eigen::VectorXd size = G.cwiseAbs() * of_columns.head(G.cols());
  std::vector<int> rows;
  for (const int k : which)
    if (moves.row(k).cwiseAbs().maxCoeff() > 1e-6 * size(k)) rows.push_back(k);
  return rows;
}

}  // namespace

StaticsReport solve_statics(const Equations& eq, State& s, const StaticsOptions& options) {
  const Sizes n = eq.sizes();
  const int n_v = n.n_v, n_c = n.n_dyn, n_a = n.n_alg, n_l = n.n_lambda, n_z = n_v + n_c + n_a;
  const bool open = options.opening.size() > 0;
  if (!open) assemble_positions(eq, s);
  s.v.setZero();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n_v);
  auto scratch = eq.make_scratch();
  KinematicBlocks kinematics(eq, s.p);
  Tangents tangents(eq), unloaded(options.unloaded ? *options.unloaded : eq);
  const auto unloaded_scratch = options.unloaded ? options.unloaded->make_scratch() : nullptr;
  Eigen::VectorXd without(n_z);
  Eigen::MatrixXd K, J(n_z + n_l, n_z + n_l);
  Eigen::VectorXd F(n_z + n_l), x, scale = Eigen::VectorXd::Ones(n_z + n_l), size_v(n_v), g(n_l);
  for (int i = 0; i < n_v; ++i) size_v(i) = eq.velocity_scale(i);
  StaticsReport report;
  // Rows of speeds, and those of them that follow states or the motion, whose drive does nothing at rest.
  std::vector<int> of_speeds, following;
  for (int k = 0; k < n_l; ++k)
    if (!eq.is_holonomic(k)) of_speeds.push_back(k);
  Eigen::VectorXd tried(n_z + n_l), g_dot(n_l), load = Eigen::VectorXd::Zero(n_v);

  auto residual = [&](const State& state, Eigen::VectorXd& out) {
    eq.momentum(state, rest, *scratch, out.head(n_v), out.segment(n_v, n_c), out.segment(n_v + n_c, n_a));
    if (options.unloaded) {
      options.unloaded->momentum(state, rest, *unloaded_scratch, without.head(n_v), without.segment(n_v, n_c),
                                 without.segment(n_v + n_c, n_a));
      out.head(n_z) = options.load * out.head(n_z) + (1.0 - options.load) * without;
    }
    if (n_l > 0) eq.position_constraints(state, state.p, *scratch, out.tail(n_l));
    if (!following.empty()) eq.velocity_constraints(state, state.p, rest, *scratch, g_dot);
    for (const int k : following) out(n_z + k) = g_dot(k);
    if (open) out.tail(n_l) -= options.opening;
  };
  // Contacts close and open on the way, like every switch whose function falls below 0.
  Eigen::VectorXd switching = Eigen::VectorXd::Zero(n.n_root);
  const auto take_switches = [&] {
    if (n.n_root == 0) return;
    eq.roots(s, *scratch, switching);
    for (int k = 0; k < n.n_root; ++k)
      if (switching(k) < 0.0) eq.on_root(k, s, *scratch);
    s.v.setZero();  // an impact leaves nothing behind here
  };
  // A step ends just behind the first switch on its way: what comes from afar would pass through the surface that it touches, or be deep
  // in it.
  int switch_stops = 0;
  constexpr int kSwitchStops = 50, kLooks = 100, kHalvings = 20;
  const auto first_switch = [&](const auto& stepped, double whole) {
    if (n.n_root == 0) return whole;
    const auto passes = [&](double part) {
      eq.roots(stepped(part), *scratch, switching);
      for (int k = 0; k < n.n_root; ++k)
        if (switching(k) < 0.0 && !eq.is_condition(k)) return true;
      return false;
    };
    for (int i = 1; i <= kLooks; ++i) {
      double to = whole * i / kLooks;
      if (!passes(to)) continue;
      double from = whole * (i - 1) / kLooks;
      for (int k = 0; k < kHalvings; ++k) {
        const double middle = 0.5 * (from + to);
        (passes(middle) ? to : from) = middle;
      }
      return to;
    }
    return whole;
  };
  const auto scale_rows = [&] {
    for (int k = 0; k < n_l; ++k) {
      const double norm = (tangents.G.row(k).transpose().array() * scale.head(n_v).array()).matrix().norm();
      scale(n_z + k) = norm > 0.0 ? 1.0 / norm : 1.0;
    }
  };
  // Conditions in formulas are as they are at each step, and held again in the equilibrium.
  bool holds_conditions = false;
  for (std::size_t k = 0; k < s.root.size(); ++k)
    if (eq.is_condition(static_cast<int>(k))) {
      holds_conditions = holds_conditions || s.root[k] != 0;
      s.root[k] = 0;
    }
  // What slides where the search ends, or is stopped for it, sticks from there: its switch stands at 0 of a speed, and a state begins
  // to hold.
  std::vector<std::string> stuck;  // their names
  const auto stick = [&] {
    stuck.clear();
    if (n.n_root == 0 || n_c == 0) return false;
    eq.roots(s, *scratch, switching);
    for (int k = 0; k < n.n_root; ++k) {
      if (s.root[k] == 0 || switching(k) != 0.0) continue;
      State held = s;
      eq.on_root(k, held, *scratch);
      if (held.c == s.c) continue;
      s = std::move(held);
      stuck.push_back(eq.describe_root(k));
    }
    return !stuck.empty();
  };
  take_switches();
  stick();
  // Without the multipliers' part: forces that no reaction carries, in the norm of M^-1.
  residual(s, F);
  require_finite_forces(eq, s.t, F.head(n_v), F.segment(n_v, n_c), F.segment(n_v + n_c, n_a));

  // What acts before any constraint answers it: a force left over is judged by this, coordinate by coordinate.
  {
    State unheld = s;
    unheld.lambda.setZero();
    Eigen::VectorXd all = F;
    residual(unheld, all);
    load = all.head(n_v).cwiseAbs();
  }
  // Whether the forces left come from round-off or from a shift that holds what nothing else does: a millionth of the load, what digits
  // of the positions make of the stiffness, an acceleration of 1e-9 m/s^2 or rad/s^2.
  const auto is_balanced = [&](const Eigen::VectorXd& left, const Eigen::MatrixXd& K) {
    for (int i = 0; i < n_v; ++i) {
      const double stiff = K.row(i).head(n_v).cwiseAbs().dot(size_v.transpose());
      if (std::abs(left(i)) > 1e-6 * load(i) + 1e-12 * stiff + 1e-9 * tangents.M(i, i) * size_v(i))
        return false;
    }
    return true;
  };
  // Whether they are round-off alone, which moves what next to nothing holds by more than the tolerance.
  const auto is_round_off = [&](const Eigen::VectorXd& left, const Eigen::MatrixXd& K) {
    for (int i = 0; i < n_v; ++i)
      if (std::abs(left(i)) > 1e-13 * load(i) + 1e-15 * K.row(i).head(n_v).cwiseAbs().dot(size_v.transpose()))
        return false;
    return true;
  };

  // Whether drives and what they follow stand still, where more equations than unknowns need not agree: 1e-8 m/s is 0.3 m in a year.
  const auto rests = [&](const Eigen::MatrixXd& K) {
    constexpr double kStill = 1e-8;
    for (const int k : following)
      if (std::abs(F(n_z + k)) > kStill) return false;
    for (int i = n_v; i < n_v + n_c; ++i) {
      const double size =
          K.row(i).cwiseAbs().dot(size_v) + tangents.z_c.row(i).cwiseAbs().dot(s.c.cwiseAbs());
      if (std::abs(F(i)) > kStill * (1.0 + size)) return false;
    }
    return true;
  };

  int n_stuck = 0;
  constexpr int kStuck = 20;
  FollowingStates states(eq);
  double extra = 0.0;   // more damping where the steps swing to and fro
  double floor = 1e-6;  // of the shift, less and less where they do not
  double last_step = 1.0;
  Eigen::MatrixXd stiffness;
  Eigen::VectorXd unit, row_unit;
  Eigen::VectorXd step_before = rest;
  Eigen::MatrixXd h_q(n_l, n_v);
  constexpr int kShortenings = 8;
  Stride stride;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    tangents.evaluate(s, rest);
    if (options.unloaded) {
      unloaded.evaluate(s, rest);
      const auto mix = [&](Eigen::MatrixXd& with, const Eigen::MatrixXd& less) {
        with = options.load * with + (1.0 - options.load) * less;
      };
      mix(tangents.z_p, unloaded.z_p);
      mix(tangents.z_v, unloaded.z_v);
      mix(tangents.z_c, unloaded.z_c);
      mix(tangents.z_a, unloaded.z_a);
    }
    kinematics.update(s.p, s.v);
    kinematics.multiply_T(tangents.z_p, K);
    for (int i = 0; i < n_v; ++i) scale(i) = tangents.M(i, i) > 0.0 ? 1.0 / std::sqrt(tangents.M(i, i)) : 1.0;
    scale_rows();
    following.clear();
    if (!of_speeds.empty()) kinematics.multiply_T(tangents.h_p, h_q);
    for (const int k : of_speeds)
      if (!h_q.row(k).isZero(0.0) || (tangents.h_c.size() > 0 && !tangents.h_c.row(k).isZero(0.0)))
        following.push_back(k);
    residual(s, F);
    states.find(s, tangents, K, F.segment(n_v, n_c), step_before);
    stiffness = K.topRows(n_v) + tangents.z_c.topRows(n_v)(Eigen::all, states.which()) * states.B();
    double sigma = 0.0;
    if (options.stable) {
      unit = scale.head(n_v);
      row_unit = scale.tail(n_l);
      sigma = downhill_shift(stiffness, tangents.G, unit, row_unit, floor);
      if (sigma > 0.0 && last_step < 1e-3 && returns(on_null_space(stiffness, tangents.G, unit, row_unit)))
        sigma = 0.0;
      // Where nothing is stiff: no step of more than a tenth of a typical size.
      if (n_v > 0 && sigma == 0.0 && stiffness.isZero() &&
          on_null_space(stiffness, tangents.G, unit, row_unit).cols() > 0)
        extra = std::max(extra, 1.0);
      sigma += extra;
    }
    J.setZero();
    J.topLeftCorner(n_z, n_v) = K;
    J.topLeftCorner(n_v, n_v).diagonal() += sigma * scale.head(n_v).cwiseAbs2().cwiseInverse();
    J.block(0, n_v, n_z, n_c) = tangents.z_c;
    J.block(0, n_v + n_c, n_z, n_a) = tangents.z_a;
    J.block(0, n_z, n_v, n_l) = tangents.G.transpose();
    if (tangents.c_lambda.size() > 0) J.block(n_v, n_z, n_c, n_l) = tangents.c_lambda;
    if (tangents.b_lambda.size() > 0) J.block(n_v + n_c, n_z, n_a, n_l) = tangents.b_lambda;
    J.block(n_z, 0, n_l, n_v) = tangents.G;
    if (tangents.g_c.size() > 0) J.block(n_z, n_v, n_l, n_c) = tangents.g_c;
    // A drive's speed by what it follows; rolling, and speeds that are given by time, hold the place that there is.
    for (const int k : following) {
      J.block(n_z + k, 0, 1, n_v) = h_q.row(k);
      if (tangents.h_c.size() > 0) J.block(n_z + k, n_v, 1, n_c) = tangents.h_c.row(k);
    }
    std::vector<int> held;
    if (!following.empty()) {
      Eigen::MatrixXd unshifted = J;
      unshifted.topLeftCorner(n_v, n_v) = K.topRows(n_v);
      held = rows_of_free_places(unshifted, tangents.G, following);
    }
    for (std::size_t i = 0; i < states.which().size(); ++i) {
      const int row = n_v + states.which()[i];
      J.block(row, 0, 1, n_v) = -states.B().row(static_cast<Eigen::Index>(i));
      J(row, row) = 1.0;
    }
    // The regularisation below is small beside the compliance of what the constraints hold only if that is 1.
    if (n_v > 0) {
      const Eigen::VectorXd by_stiffness = units_of_stiffness(stiffness, tangents.G, scale.head(n_v));
      if (by_stiffness.size() > 0) {
        scale.head(n_v) = by_stiffness;
        scale_rows();
      }
    }
    J = scale.asDiagonal() * J * scale.asDiagonal();
    J.bottomRightCorner(n_l, n_l).diagonal().array() -= 1e-13;
    x = -scale.cwiseProduct(F);
    if (held.empty()) {
      x = J.partialPivLu().solve(x).eval();
    } else {
      // Drives that come to rest wherever they are stay where they are: as many equations more as places.
      const auto n_held = static_cast<Eigen::Index>(held.size());
      Eigen::MatrixXd all = Eigen::MatrixXd::Zero(J.rows() + n_held, J.cols());
      all.topRows(J.rows()) = J;
      all.bottomLeftCorner(n_held, n_v) =
          (tangents.G(held, Eigen::all) * scale.head(n_v).asDiagonal()).rowwise().normalized();
      Eigen::VectorXd with_held = Eigen::VectorXd::Zero(all.rows());
      with_held.head(x.size()) = x;
      x = all.colPivHouseholderQr().solve(with_held);
    }
    x = scale.cwiseProduct(x).eval();
    ++report.iterations;
    const double step = x.allFinite() ? x.head(n_v).cwiseQuotient(size_v).lpNorm<Eigen::Infinity>()
                                      : std::numeric_limits<double>::infinity();
    if (!(step < 1e6)) {
      extra = std::max(4.0 * extra, 1.0);
      continue;
    }
    double alpha = stride.part(step);
    states.begin_step(s, x.head(n_v));
    for (const int k : states.which()) x(n_v + k) = 0.0;  // they move by their own law
    const auto stepped = [&](double part) {
      State next = s;
      eq.retract(s.p, part * x.head(n_v), next.p);
      next.c += part * x.segment(n_v, n_c);
      states.move(part, next.c);
      next.a += part * x.segment(n_v + n_c, n_a);
      next.lambda += x.tail(n_l);
      return next;
    };
    if (switch_stops < kSwitchStops && step > 1e-6) {
      const double first = first_switch(stepped, alpha);
      switch_stops += first < alpha;
      alpha = first;
    }
    if (options.stable && step > 1e-6) {
      const double slope = (F.head(n_v) + tangents.G.transpose() * x.tail(n_l)).dot(x.head(n_v));
      for (int k = 0; k < kShortenings; ++k) {
        residual(stepped(alpha), tried);
        if (stride.stands(slope, tried.head(n_v).dot(x.head(n_v)), alpha)) break;
      }
    }
    s = stepped(alpha);
    take_switches();
    residual(s, F);
    require_finite_forces(eq, s.t, F.head(n_v), F.segment(n_v, n_c), F.segment(n_v + n_c, n_a));
    report.force_residual = F.head(n_v).lpNorm<Eigen::Infinity>();
    report.constraint_residual = n_l > 0 ? F.tail(n_l).cwiseAbs().maxCoeff() : 0.0;
    // Where nothing is stiff and no force is left any position is an equilibrium.
    const bool indifferent = step < 1e-6 * options.tolerance && stiffness.isZero();
    if (alpha == 1.0 && (step < options.tolerance || (step < 1e-6 && is_round_off(F.head(n_v), K))) &&
        (sigma == 0.0 || is_balanced(F.head(n_v), K)) &&
        (indifferent || extra < 1e-9 * (1.0 + K.lpNorm<Eigen::Infinity>()))) {
      if (!held.empty() && !rests(K))
        throw std::runtime_error(
            fmt::format("no equilibrium at t = {:.6g} s: the drive \"{}\" moves on wherever it stands; let "
                        "what it follows "
                        "come to rest, or feed back its place",
                        s.t, eq.name_of_constraint(held.front())));
      if (n_stuck++ < kStuck && stick()) continue;
      for (std::size_t i = 0; i < states.which().size(); ++i)
        if (const int k = states.which()[i];
            !states.B().row(static_cast<Eigen::Index>(i)).isZero(0.0) && !tangents.z_c.col(k).isZero(0.0))
          report.following_the_way.push_back(eq.name_of_dynamic(k));
      if (holds_conditions) eq.hold_conditions(s, *scratch);
      return report;
    }
    if (options.stable) {
      const bool swings = x.head(n_v).dot(step_before) < 0.0 && x.head(n_v).norm() > 0.5 * step_before.norm();
      // Halves a step along this one.
      const auto d = x.head(n_v);
      const double along = std::abs(d.dot(stiffness * d)) / std::max(d.dot(tangents.M * d), 1e-300);
      extra = swings ? std::max(4.0 * extra, along) : (step < 1e-3 ? 1e-3 : 0.5) * extra;
      floor = swings ? std::min(4.0 * floor, 1e-6) : std::max(0.25 * floor, 1e-10);
    }
    step_before = x.head(n_v);
    last_step = step;
  }
  if (n_v == 0) throw std::runtime_error("no equilibrium found of a mechanism that cannot move");
  int worst = 0;
  F.head(n_v).cwiseAbs().maxCoeff(&worst);
  const double left = F(worst);
  if (stick())
    throw std::runtime_error(
        fmt::format("no equilibrium found in {} steps at t = {:.6g} s: on \"{}\" {:.4g} N (or N m) are left "
                    "unbalanced; {} lets go, for more "
                    "pulls there than friction holds: raise its limit, or hold it by a spring or a stop",
                    report.iterations, s.t, eq.name_of_velocity(worst), left, fmt::join(stuck, ", ")));
  throw std::runtime_error(fmt::format(
      "no equilibrium found in {} steps at t = {:.6g} s: on \"{}\" {:.4g} N (or N m) are left "
      "unbalanced; something may be free to run away: hold it by a joint or a spring; what is only soft "
      "comes to rest in a damped run (flexura simulate)",
      report.iterations, s.t, eq.name_of_velocity(worst), left));
}

}  // namespace flexura::mbs
