// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/model/checks.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace flexura::mbs::checks {

State random_state(const Mechanism& mechanism, unsigned seed, double size) {
  Random random(seed);
  State s = mechanism.initial_state();
  const Sizes n = mechanism.sizes();
  s.t = 0.3;
  VectorXd d = random.vector(n.n_v, size);
  for (int i = 0; i < n.n_v; ++i) d(i) *= std::min(1.0, mechanism.velocity_scale(i));
  mechanism.retract(s.p, d, s.p);
  s.v = random.vector(n.n_v, 1.5);
  for (int i = 0; i < n.n_v; ++i) s.v(i) *= std::min(1.0, mechanism.velocity_scale(i));
  s.lambda = random.vector(n.n_lambda, 2.0);
  return s;
}

State carried(const Mechanism& mechanism, const State& s, const VectorXd& v_dot, double h) {
  State next = s;
  next.t = s.t + h;
  mechanism.retract(s.p, h * s.v + 0.5 * h * h * v_dot, next.p);
  next.v = s.v + h * v_dot;
  return next;
}

VectorXd momentum(const Mechanism& mechanism, const State& s, const VectorXd& v_dot) {
  const auto scratch = mechanism.make_scratch();
  const Sizes n = mechanism.sizes();
  VectorXd r(n.n_v), c_rate(n.n_dyn), b(n.n_alg);
  mechanism.momentum(s, v_dot, *scratch, r, c_rate, b);
  return r;
}

void mass_matrix_is_slope_of_momentum(const Mechanism& mechanism, const State& s) {
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

  // The recursive inverse, while other evaluations use other work space.
  ASSERT_TRUE(mechanism.factor_mass(s.p, *scratch));
  VectorXd x = M * VectorXd::LinSpaced(n, -1.0, 1.0);
  mechanism.solve_mass(*scratch, x);
  EXPECT_LE((x - VectorXd::LinSpaced(n, -1.0, 1.0)).cwiseAbs().maxCoeff(),
            1e-14 * n * eigenvalues(n - 1) / eigenvalues(0));
}

void kinetic_energy_is_quadratic_form(const Mechanism& mechanism, const State& s) {
  const auto scratch = mechanism.make_scratch();
  const int n = static_cast<int>(s.v.size());
  MatrixXd M(n, n);
  mechanism.mass_matrix(s.p, *scratch, M);
  const double T = mechanism.energy(s, VectorXd::Zero(n), *scratch).kinetic;
  EXPECT_NEAR(T, 0.5 * s.v.dot(M * s.v), 1e-13 * (1.0 + T) * n);
}

void constraints_are_consistent(const Mechanism& mechanism, const State& s, unsigned seed) {
  const auto scratch = mechanism.make_scratch();
  const Sizes n = mechanism.sizes();
  if (n.n_lambda == 0) return;
  Random random(seed);
  {
    // All at once is what the parts are.
    const VectorXd v_dot = random.vector(n.n_v), mu = random.vector(n.n_lambda);
    VectorXd r(n.n_v), c_rate(n.n_dyn), b(n.n_alg), g_dot(n.n_lambda), g(n.n_lambda), f_c(n.n_v);
    VectorXd g_dot_alone(n.n_lambda), g_alone(n.n_lambda), f_c_alone(n.n_v);
    mechanism.residuals(s, v_dot, mu, *scratch, r, c_rate, b, g_dot, g, f_c);
    mechanism.velocity_constraints(s.t, s.p, s.v, *scratch, g_dot_alone);
    mechanism.position_constraints(s.t, s.p, *scratch, g_alone);
    mechanism.apply_GT(s.t, s.p, mu, *scratch, f_c_alone);
    // To the bit; a contact on a curve is found to round-off from wherever it was.
    const double tolerance = n.n_alg > 0 ? 1e-12 * (1.0 + r.norm()) : 0.0;
    EXPECT_LE((r - momentum(mechanism, s, v_dot)).norm(), tolerance);
    EXPECT_LE((g_dot - g_dot_alone).norm(), tolerance);
    EXPECT_LE((g - g_alone).norm(), tolerance);
    EXPECT_LE((f_c - f_c_alone).norm(), tolerance);
  }
  MatrixXd G(n.n_lambda, n.n_v);
  mechanism.constraint_matrix(s.t, s.p, *scratch, G);
  // Central differences with one Richardson step: what is left is h^4 times fifth derivatives.  Unit modal
  // coordinates move and turn nodes by some tens, so these reach 1e6 and the error 1e-9; round-off is 1e-16 /
  // h = 1e-12.
  const double h = 2e-4;
  const auto derivative = [h](const auto& f) {
    const auto central = [&](double step) { return VectorXd((f(step) - f(-step)) / (2 * step)); };
    return VectorXd((4 * central(0.5 * h) - central(h)) / 3);
  };
  VectorXd p(n.n_p);
  for (int i = 0; i < n.n_v; ++i) {
    const VectorXd column = derivative([&](double step) {
      VectorXd g(n.n_lambda);
      mechanism.retract(s.p, step * VectorXd::Unit(n.n_v, i), p);
      mechanism.position_constraints(s.t, p, *scratch, g);
      return g;
    });
    for (int row = 0; row < n.n_lambda; ++row) {
      if (mechanism.is_holonomic(row)) {
        EXPECT_NEAR(G(row, i), column(row), 1e-8 * (1 + std::abs(column(row))))
            << mechanism.name_of_constraint(row) << " by " << mechanism.name_of_velocity(i);
      }
    }
  }

  VectorXd f_c(n.n_v), x = random.vector(n.n_lambda);
  mechanism.apply_GT(s.t, s.p, x, *scratch, f_c);
  EXPECT_LE((f_c - G.transpose() * x).cwiseAbs().maxCoeff(),
            1e-13 * n.n_lambda * (1 + G.cwiseAbs().maxCoeff()));

  VectorXd v_dot = random.vector(n.n_v);
  for (int i = 0; i < n.n_v; ++i) v_dot(i) *= std::min(1.0, mechanism.velocity_scale(i));
  VectorXd g_dot(n.n_lambda), g_ddot(n.n_lambda);
  mechanism.velocity_constraints(s.t, s.p, s.v, *scratch, g_dot);
  mechanism.acceleration_constraints(s.t, s.p, s.v, v_dot, *scratch, g_ddot);
  const VectorXd g_dot_fd = derivative([&](double step) {
    VectorXd g(n.n_lambda);
    mechanism.position_constraints(s.t + step, carried(mechanism, s, v_dot, step).p, *scratch, g);
    return g;
  });
  // The carried motion is right to second order in the step: its h^2 error is odd in h only from h^3 on for
  // positions and cancels in Richardson's combination.
  const VectorXd g_ddot_fd = derivative([&](double step) {
    VectorXd g(n.n_lambda);
    const State at = carried(mechanism, s, v_dot, step);
    mechanism.velocity_constraints(at.t, at.p, at.v, *scratch, g);
    return g;
  });
  for (int row = 0; row < n.n_lambda; ++row) {
    if (mechanism.is_holonomic(row)) {
      EXPECT_NEAR(g_dot(row), g_dot_fd(row), 1e-8 * (1 + std::abs(g_dot(row))))
          << mechanism.name_of_constraint(row);
    }
    EXPECT_NEAR(g_ddot(row), g_ddot_fd(row), 1e-7 * (1 + g_ddot.cwiseAbs().maxCoeff()))
        << mechanism.name_of_constraint(row);
  }
}

void power_balances(const Mechanism& mechanism, const State& s, unsigned seed) {
  const auto scratch = mechanism.make_scratch();
  const Sizes n = mechanism.sizes();
  Random random(seed);
  VectorXd v_dot = random.vector(n.n_v);
  for (int i = 0; i < n.n_v; ++i) v_dot(i) *= std::min(1.0, mechanism.velocity_scale(i));
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

void lagrange_equations_hold(const Mechanism& mechanism, const State& s, unsigned seed) {
  const auto scratch = mechanism.make_scratch();
  const Sizes n = mechanism.sizes();
  ASSERT_EQ(n.n_p, n.n_v);
  Random random(seed);
  VectorXd v_dot = random.vector(n.n_v);
  for (int i = 0; i < n.n_v; ++i) v_dot(i) *= std::min(1.0, mechanism.velocity_scale(i));
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
  const double h = 5e-4;
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

void all_identities_hold(const Mechanism& mechanism, unsigned seed) {
  const State s = random_state(mechanism, seed);
  mass_matrix_is_slope_of_momentum(mechanism, s);
  kinetic_energy_is_quadratic_form(mechanism, s);
  constraints_are_consistent(mechanism, s, seed + 100);
  power_balances(mechanism, s, seed + 200);
}

void assemble(const Mechanism& mechanism, State& s) {
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

MechanismDescription chain_of(std::shared_ptr<const FlexibleBody> first_body,
                              std::shared_ptr<const FlexibleBody> second_body,
                              const std::string& middle_joint) {
  MechanismDescription d;
  d.gravity = {0.5, -9.0, 2.0};
  Random random(5);
  int previous = 0;
  const char* types[] = {"prismatic", "prismatic", "prismatic", "revolute", "revolute"};
  for (int i = 0; i < 5; ++i) {
    const int carrier = d.add_body({.name = "carrier_" + std::to_string(i), .inertia = random.inertia()});
    d.add_joint("j_" + std::to_string(i), types[i],
                d.add_marker(previous, "o" + std::to_string(i), random.pose()),
                d.add_marker(carrier, "i", random.pose()));
    previous = carrier;
  }
  const int first = d.add_body({.name = "first", .flexible = std::move(first_body)});
  d.add_joint("held", "revolute", d.add_marker(previous, "hand", random.pose()),
              d.add_marker(first, "left", random.pose(0.2), 0));
  const int weight = d.add_body({.name = "weight", .inertia = random.inertia()});
  d.add_joint("middle", middle_joint, d.add_marker(first, "right", random.pose(0.2), 1),
              d.add_marker(weight, "in", random.pose()));
  const int second = d.add_body({.name = "second", .flexible = std::move(second_body)});
  d.add_joint("reversed", "prismatic", d.add_marker(second, "right", random.pose(0.3), 1),
              d.add_marker(first, "right_too", {}, 1));
  return d;
}

}  // namespace flexura::mbs::checks
