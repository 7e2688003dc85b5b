// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>

#include "mbs/model/mechanism.hpp"

/// Identities that every mechanism must satisfy at every state, consistent or not.  Scales: coordinates,
/// speeds, lengths and masses of the test mechanisms are of order one.
namespace flexura::mbs::checks {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double operator()(double low = -1.0, double high = 1.0) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  VectorXd vector(int n, double size = 1.0) {
    VectorXd x(n);
    for (double& value : x) value = size * (*this)();
    return x;
  }
  Vector3d vector3(double size = 1.0) { return {size * (*this)(), size * (*this)(), size * (*this)()}; }
  Pose pose(double size = 0.5) { return {rotation_exp(vector3(2.0)), vector3(size)}; }
  /// Mass, centre and inertia of four random point masses: always possible.
  RigidInertia inertia() {
    RigidInertia I;
    for (int i = 0; i < 4; ++i) {
      const Vector3d x = vector3(0.6);
      const double m = (*this)(0.2, 1.0);
      I.mass += m;
      I.mass_center += m * x;
      I.inertia += m * (x.squaredNorm() * Matrix3d::Identity() - x * x.transpose());
    }
    return I;
  }

 private:
  std::mt19937 engine_;
};

/// p moved from the initial one by a random tangent of this size, modal coordinates by a part of it.
inline State random_state(const Mechanism& mechanism, unsigned seed, double size = 0.7) {
  Random random(seed);
  State s = mechanism.initial_state();
  const Sizes n = mechanism.sizes();
  s.t = 0.3;
  VectorXd d = random.vector(n.n_v, size);
  for (int i = 0; i < n.n_v; ++i) d(i) *= std::min(1.0, 0.05 * mechanism.velocity_scale(i) + 0.95);
  mechanism.retract(s.p, d, s.p);
  s.v = random.vector(n.n_v, 1.5);
  s.lambda = random.vector(n.n_lambda, 2.0);
  return s;
}

/// State and acceleration carried forward by h: second order in h.
inline State carried(const Mechanism& mechanism, const State& s, const VectorXd& v_dot, double h) {
  State next = s;
  next.t = s.t + h;
  mechanism.retract(s.p, h * s.v + 0.5 * h * h * v_dot, next.p);
  next.v = s.v + h * v_dot;
  return next;
}

inline VectorXd momentum(const Mechanism& mechanism, const State& s, const VectorXd& v_dot) {
  const auto scratch = mechanism.make_scratch();
  VectorXd r(s.v.size()), none(0), none_either(0);
  mechanism.momentum(s, v_dot, *scratch, r, none, none_either);
  return r;
}

/// momentum(v_dot) is affine in v_dot with the slope M; M is symmetric and positive definite.
inline void mass_matrix_is_slope_of_momentum(const Mechanism& mechanism, const State& s) {
  const auto scratch = mechanism.make_scratch();
  const int n = static_cast<int>(s.v.size());
  MatrixXd M(n, n), slope(n, n);
  mechanism.mass_matrix(s.p, *scratch, M);
  const VectorXd r_0 = momentum(mechanism, s, VectorXd::Zero(n));
  for (int i = 0; i < n; ++i) slope.col(i) = momentum(mechanism, s, VectorXd::Unit(n, i)) - r_0;
  // Round-off of sums over some ten bodies with forces r_0 that cancel.
  const double tolerance = 1e-13 * (M.cwiseAbs().maxCoeff() + r_0.cwiseAbs().maxCoeff());
  EXPECT_LE((M - slope).cwiseAbs().maxCoeff(), tolerance);
  EXPECT_LE((M - M.transpose()).cwiseAbs().maxCoeff(), tolerance);
  const VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(M, Eigen::EigenvaluesOnly).eigenvalues();
  EXPECT_GT(eigenvalues(0), 0.0);
}

/// T = v^T M v / 2.
inline void kinetic_energy_is_quadratic_form(const Mechanism& mechanism, const State& s) {
  const auto scratch = mechanism.make_scratch();
  const int n = static_cast<int>(s.v.size());
  MatrixXd M(n, n);
  mechanism.mass_matrix(s.p, *scratch, M);
  const double T = mechanism.energy(s, VectorXd::Zero(n), *scratch).kinetic;
  EXPECT_NEAR(T, 0.5 * s.v.dot(M * s.v), 1e-13 * (1.0 + T) * n);
}

/// G is the derivative of g; G v + g_t, G^T x and the second derivative agree with it.
inline void constraints_are_consistent(const Mechanism& mechanism, const State& s, unsigned seed) {
  const auto scratch = mechanism.make_scratch();
  const Sizes n = mechanism.sizes();
  if (n.n_lambda == 0) return;
  Random random(seed);
  MatrixXd G(n.n_lambda, n.n_v), G_fd(n.n_lambda, n.n_v);
  mechanism.constraint_matrix(s.t, s.p, *scratch, G);
  // Central differences: truncation h^2/6 g''' ~ 1e-9 for h = 1e-4 / (size of g''' ~ 1 to 10), round-off
  // 1e-12.
  const double h = 3e-5;
  VectorXd plus(n.n_lambda), minus(n.n_lambda), p(n.n_p);
  for (int i = 0; i < n.n_v; ++i) {
    mechanism.retract(s.p, h * VectorXd::Unit(n.n_v, i), p);
    mechanism.position_constraints(s.t, p, *scratch, plus);
    mechanism.retract(s.p, -h * VectorXd::Unit(n.n_v, i), p);
    mechanism.position_constraints(s.t, p, *scratch, minus);
    G_fd.col(i) = (plus - minus) / (2 * h);
  }
  for (int row = 0; row < n.n_lambda; ++row)
    if (mechanism.is_holonomic(row)) {
      EXPECT_LE((G - G_fd).row(row).cwiseAbs().maxCoeff(), 2e-8) << mechanism.name_of_constraint(row);
    }

  VectorXd f_c(n.n_v), x = random.vector(n.n_lambda);
  mechanism.apply_GT(s.t, s.p, x, *scratch, f_c);
  EXPECT_LE((f_c - G.transpose() * x).cwiseAbs().maxCoeff(),
            1e-13 * n.n_lambda * (1 + G.cwiseAbs().maxCoeff()));

  const VectorXd v_dot = random.vector(n.n_v);
  VectorXd g_dot(n.n_lambda), g_ddot(n.n_lambda);
  mechanism.velocity_constraints(s.t, s.p, s.v, *scratch, g_dot);
  mechanism.acceleration_constraints(s.t, s.p, s.v, v_dot, *scratch, g_ddot);
  const State ahead = carried(mechanism, s, v_dot, h), behind = carried(mechanism, s, v_dot, -h);
  mechanism.position_constraints(ahead.t, ahead.p, *scratch, plus);
  mechanism.position_constraints(behind.t, behind.p, *scratch, minus);
  const VectorXd g_dot_fd = (plus - minus) / (2 * h);
  VectorXd plus_dot(n.n_lambda), minus_dot(n.n_lambda);
  mechanism.velocity_constraints(ahead.t, ahead.p, ahead.v, *scratch, plus_dot);
  mechanism.velocity_constraints(behind.t, behind.p, behind.v, *scratch, minus_dot);
  const VectorXd g_ddot_fd = (plus_dot - minus_dot) / (2 * h);
  // Third and fourth derivatives along the motion reach some hundreds at speeds of order one in chains of
  // joints.
  for (int row = 0; row < n.n_lambda; ++row) {
    if (mechanism.is_holonomic(row)) {
      EXPECT_NEAR(g_dot(row), g_dot_fd(row), 2e-7 * (1 + std::abs(g_dot(row))))
          << mechanism.name_of_constraint(row);
    }
    EXPECT_NEAR(g_ddot(row), g_ddot_fd(row), 2e-7 * (1 + g_ddot.cwiseAbs().maxCoeff()))
        << mechanism.name_of_constraint(row);
  }
}

/// (T + U + V)' = v . r + input - dissipated - lambda . (G v + g_t) for any acceleration and any multipliers.
inline void power_balances(const Mechanism& mechanism, const State& s, unsigned seed) {
  const auto scratch = mechanism.make_scratch();
  const Sizes n = mechanism.sizes();
  Random random(seed);
  const VectorXd v_dot = random.vector(n.n_v);
  const auto energy = [&](const State& at) {
    const EnergyReport e = mechanism.energy(at, v_dot, *scratch);
    return e.kinetic + e.strain + e.potential;
  };
  // Central differences with one Richardson step: the error h^4 E^(5) / 30 of h = 1e-3 and the round-off
  // 1e-16 E / h are both below 1e-9 of the powers.
  const auto difference = [&](double h) {
    return (energy(carried(mechanism, s, v_dot, h)) - energy(carried(mechanism, s, v_dot, -h))) / (2 * h);
  };
  const double h = 1e-3, rate = (4 * difference(0.5 * h) - difference(h)) / 3;
  const EnergyReport e = mechanism.energy(s, v_dot, *scratch);
  VectorXd g_dot(n.n_lambda);
  mechanism.velocity_constraints(s.t, s.p, s.v, *scratch, g_dot);
  const VectorXd r = momentum(mechanism, s, v_dot);
  const double balance = s.v.dot(r) + e.input_power - e.dissipated_power - s.lambda.dot(g_dot);
  EXPECT_NEAR(rate, balance, 1e-7 * (1.0 + s.v.cwiseAbs().dot(r.cwiseAbs())));
}

/// For coordinates with p' = v (no quaternions) and no applied forces but conservative ones and constraints:
/// r = d/dt (dT/dv) - d(T - U - V)/dp + G^T lambda, every component.
inline void lagrange_equations_hold(const Mechanism& mechanism, const State& s, unsigned seed) {
  const auto scratch = mechanism.make_scratch();
  const Sizes n = mechanism.sizes();
  ASSERT_EQ(n.n_p, n.n_v);
  Random random(seed);
  const VectorXd v_dot = random.vector(n.n_v);
  const auto energies = [&](const State& at) { return mechanism.energy(at, v_dot, *scratch); };
  // T is a quadratic form in v: the difference over +-1 is exact.
  const auto momenta = [&](const State& at) {
    VectorXd x(n.n_v);
    for (int i = 0; i < n.n_v; ++i) {
      State a = at, b = at;
      a.v(i) += 1.0;
      b.v(i) -= 1.0;
      x(i) = 0.5 * (energies(a).kinetic - energies(b).kinetic);
    }
    return x;
  };
  const double h = 2e-3;
  const auto along = [&](double step) {  // exact in p' = v: p moves by h v + h^2/2 v'
    return VectorXd(
        (momenta(carried(mechanism, s, v_dot, step)) - momenta(carried(mechanism, s, v_dot, -step))) /
        (2 * step));
  };
  const VectorXd d_dt = (4 * along(0.5 * h) - along(h)) / 3;
  VectorXd d_dp(n.n_v);
  for (int i = 0; i < n.n_v; ++i) {
    const auto at = [&](double step) {
      State a = s;
      a.p(i) += step;
      const EnergyReport e = energies(a);
      return e.kinetic - e.strain - e.potential;
    };
    const auto slope = [&](double step) { return (at(step) - at(-step)) / (2 * step); };
    d_dp(i) = (4 * slope(0.5 * h) - slope(h)) / 3;
  }
  VectorXd reaction(n.n_v);
  mechanism.apply_GT(s.t, s.p, s.lambda, *scratch, reaction);
  const VectorXd r = momentum(mechanism, s, v_dot), expected = d_dt - d_dp + reaction;
  for (int i = 0; i < n.n_v; ++i)
    EXPECT_NEAR(r(i), expected(i), 2e-8 * (1.0 + r.cwiseAbs().maxCoeff())) << mechanism.name_of_velocity(i);
}

inline void all_identities_hold(const Mechanism& mechanism, unsigned seed) {
  const State s = random_state(mechanism, seed);
  mass_matrix_is_slope_of_momentum(mechanism, s);
  kinetic_energy_is_quadratic_form(mechanism, s);
  constraints_are_consistent(mechanism, s, seed + 100);
  power_balances(mechanism, s, seed + 200);
}

/// Newton's method with least-norm steps; the residual is below 1e-13 afterwards.
inline void assemble(const Mechanism& mechanism, State& s) {
  const auto scratch = mechanism.make_scratch();
  const Sizes n = mechanism.sizes();
  VectorXd g(n.n_lambda), next(n.n_p);
  MatrixXd G(n.n_lambda, n.n_v);
  for (int k = 0; k < 50; ++k) {
    mechanism.position_constraints(s.t, s.p, *scratch, g);
    if (g.cwiseAbs().maxCoeff() < 1e-13) return;
    mechanism.constraint_matrix(s.t, s.p, *scratch, G);
    const VectorXd step = Eigen::CompleteOrthogonalDecomposition<MatrixXd>(G).solve(-g);
    mechanism.retract(s.p, step, next);
    s.p = next;
  }
  FAIL() << "the mechanism does not close, residual " << g.cwiseAbs().maxCoeff();
}

}  // namespace flexura::mbs::checks
