// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/perturbation.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "mbs/solver/algebra/kinematic_blocks.hpp"

namespace flexura::mbs {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kStep = 1e-4;  // of a typical size: truncation 1e-16 and round-off 1e-12 of the terms

}  // namespace

Perturbation::Perturbation(const Equations& eq, const State& s, const VectorXd& v_dot,
                           const std::vector<int>& inputs)
    : t(eq) {
  const Sizes n = eq.sizes();
  const int n_z = n.n_v + n.n_dyn + n.n_alg, n_l = n.n_lambda;
  t.evaluate(s, v_dot);
  kinematics(eq, s);
  g_c.setZero(n_l, n.n_dyn);
  h_c = g_c;
  if (t.g_c.size() > 0) {
    g_c = t.g_c;
    h_c = t.h_c;
  }
  const auto scratch = eq.make_scratch();
  const auto accelerations = [&](const State& at) {
    VectorXd a(n_l);
    eq.acceleration_constraints(at, at.p, at.v, v_dot, *scratch, a);
    return a;
  };
  a_q.setZero(n_l, n.n_v);
  a_v = a_q;
  a_c = g_c;
  a_c.setZero();
  a_a.setZero(n_l, n.n_alg);
  const auto along = [&](VectorXd State::*member, int j, double size) {
    State moved = s;
    return difference(
        [&](double h) {
          (moved.*member)(j) = (s.*member)(j) + h;
          return accelerations(moved);
        },
        kStep * size);
  };
  if (n_l > 0) {
    for (int j = 0; j < n.n_v; ++j) {
      State moved = s;
      a_q.col(j) = difference(
          [&](double h) {
            eq.retract(s.p, h * VectorXd::Unit(n.n_v, j), moved.p);
            return accelerations(moved);
          },
          kStep * eq.velocity_scale(j));
      a_v.col(j) = along(&State::v, j, eq.velocity_scale(j));
    }
    for (int j = 0; j < n.n_dyn && eq.follows_states(); ++j)
      a_c.col(j) = along(&State::c, j, std::max(1.0, std::abs(s.c(j))));
    for (int j = 0; j < n.n_alg; ++j) a_a.col(j) = along(&State::a, j, std::max(1.0, std::abs(s.a(j))));
  }
  const auto n_u = static_cast<Eigen::Index>(inputs.size());
  z_u.setZero(n_z, n_u);
  for (MatrixXd* m : {&g_u, h_u.data(), &h_u[1], a_u.data(), &a_u[1], &a_u[2]}) m->setZero(n_l, n_u);
  for (Eigen::Index k = 0; k < n_u; ++k) {
    const int input = inputs[static_cast<std::size_t>(k)];
    const double step = kStep * std::max(1.0, std::abs(eq.input_value(input, s.t)));

    const auto by = [&](int order, const auto& f) {
      State moved = s;
      return difference(
          [&](double h) {
            moved.u = h * VectorXd::Unit(3 * eq.n_inputs(), order * eq.n_inputs() + input);
            return f(moved);
          },
          step);
    };
    z_u.col(k) = by(0, [&](const State& at) {
      VectorXd z(n_z);
      eq.momentum(at, v_dot, *scratch, z.head(n.n_v), z.segment(n.n_v, n.n_dyn), z.tail(n.n_alg));
      return z;
    });
    if (n_l == 0 || !eq.follows_states()) continue;
    g_u.col(k) = by(0, [&](const State& at) {
      VectorXd g(n_l);
      eq.position_constraints(at, at.p, *scratch, g);
      return g;
    });
    for (int order = 0; order < 2; ++order)
      h_u[order].col(k) = by(order, [&](const State& at) {
        VectorXd h(n_l);
        eq.velocity_constraints(at, at.p, at.v, *scratch, h);
        return h;
      });
    for (int order = 0; order < 3; ++order) a_u[order].col(k) = by(order, accelerations);
  }
}

// W = T^+ (d(T v)/dp T - T'): how the moving coordinates turn with the motion; zero at rest.
void Perturbation::kinematics(const Equations& eq, const State& s) {
  const Sizes n = eq.sizes();
  KinematicBlocks blocks(eq, s.p);
  blocks.update(s.p, s.v);
  blocks.multiply_T(t.z_p, z_q);
  blocks.multiply_T(t.h_p, h_q);
  W.setZero(n.n_v, n.n_v);
  T_inverse.setZero(n.n_v, n.n_p);
  names.resize(static_cast<std::size_t>(n.n_v));
  VectorXd p_dot(n.n_p);
  eq.kinematic(s.p, s.v, p_dot);
  const auto rate = [&](const VectorXd& p, const VectorXd& w) {
    VectorXd out(n.n_p);
    eq.kinematic(p, w, out);
    return out;
  };
  for (const auto& b : blocks.blocks()) {
    if (b.v.empty()) continue;
    for (const int j : b.v)
      names[static_cast<std::size_t>(j)] =
          b.p.size() == 1 ? eq.name_of_position(b.p[0]) : "integral of " + eq.name_of_velocity(j);
    T_inverse(b.v, b.p) = b.T_inverse;
    if (s.v.isZero(0.0) || b.p.size() == 1) continue;
    for (std::size_t j = 0; j < b.v.size(); ++j) {
      const VectorXd unit = VectorXd::Unit(n.n_v, b.v[j]);
      VectorXd moved = VectorXd::Zero(n.n_p);
      moved(b.p) = b.T.col(static_cast<Eigen::Index>(j));
      // T is of second order in p at most: long steps are exact.
      const VectorXd turns =
          difference([&](double h) { return rate(s.p + h * moved, s.v); }, 1e-2) -
          difference([&](double h) { return rate(s.p + h * p_dot, unit); }, 1e-2 / (1.0 + p_dot.norm()));
      W(b.v, b.v[j]) = b.T_inverse * turns(b.p);
    }
  }
}

std::vector<bool> held_states(const Equations& eq, const State& s, const VectorXd& v_dot) {
  const Sizes n = eq.sizes();
  std::vector<bool> held(static_cast<std::size_t>(n.n_dyn), n.n_dyn > 0);
  if (n.n_dyn == 0) return held;
  const auto scratch = eq.make_scratch();
  VectorXd r(n.n_v), c(n.n_dyn), b(n.n_alg);
  for (int probe = 0; probe < 3; ++probe) {
    State moved = s;
    // As good as any others: no two entries by the same.
    double number = 0.0;
    const auto shift = [&](VectorXd& x, double size) {
      for (double& entry : x) entry += probe * size * (0.3 + 0.1 * std::sin(++number + 2.0 * probe));
    };
    VectorXd d = VectorXd::Zero(n.n_v), by_v = v_dot;
    shift(d, 0.1);
    eq.retract(s.p, d, moved.p);
    shift(moved.v, 1.0);
    shift(moved.lambda, 1.0);
    shift(moved.a, 1.0);
    shift(by_v, 1.0);
    moved.u.setZero(3 * eq.n_inputs());
    shift(moved.u, 1.0);
    shift(moved.c, 1.0);
    try {
      eq.momentum(moved, by_v, *scratch, r, c, b);
    } catch (const std::runtime_error&) {  // a formula without a value there
      continue;
    }
    for (int j = 0; j < n.n_dyn; ++j)
      if (c(j) != 0.0) held[static_cast<std::size_t>(j)] = false;
  }
  return held;
}

}  // namespace flexura::mbs
