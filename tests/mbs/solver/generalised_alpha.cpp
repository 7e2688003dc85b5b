// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/mbs/solver/method_runs.hpp"
#include "tests/mbs/solver/planar.hpp"

namespace flexura::mbs::test {
namespace {

SolverOptions options(double end_time, double tolerance, double fixed_step = 0.0) {
  SolverOptions o = until(end_time, tolerance, "generalised_alpha");
  o.fixed_step = fixed_step;
  return o;
}

TEST(GeneralisedAlpha, ConvergesWithOrderTwoInPositionsVelocitiesAndMultipliers) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << -1.0, 0.0;
  // IFToMM A01 at t = 1 s; velocity and rod force from the energy, v^2 = -2 g y, lambda = -3 g y.
  const Eigen::Vector2d exact(.986291751132, -.165010853126);
  const double speed = std::sqrt(2.0 * 9.81 * .165010853126), force = 3.0 * 9.81 * .165010853126;
  double error[3][3];
  for (int k = 0; k < 3; ++k) {
    const RunResult r = simulate(m, s, options(1.0, 1e-10, 0.01 / (1 << k)));
    error[k][0] = (r.state.p - exact).norm();
    error[k][1] = std::abs(r.state.v.norm() - speed);
    error[k][2] = std::abs(r.state.lambda(0) - force);
    // g to Newton's tolerance, 1e-12 of the unit length.
    EXPECT_LT(r.peak_position_drift, 1e-10);
  }
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 2; ++k) {
      // 2^2 = 4; halves and quarters of the step leave a few per cent of higher order.
      EXPECT_GT(error[k][i] / error[k + 1][i], 3.4) << i;
      EXPECT_LT(error[k][i] / error[k + 1][i], 4.6) << i;
    }
}

TEST(GeneralisedAlpha, ErrorFollowsTheToleranceThroughAndrewsMechanism) {
  const PlanarMechanism m = andrews();
  State s = make_state(m);
  s.p << -0.0617138900142764496, 0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
      -0.222668390165885885, 1.23054744454982119;
  Eigen::VectorXd q(7);
  q << 15.81077119629904, -15.75637105984298, .04082224013073101, -.5347301163226948, .5244099658805304,
      .5347301163226948, 1.048080741042263;
  double before = 1.0;
  for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
    const RunResult r = simulate(m, s, options(0.03, tolerance));
    const double error = ((r.state.p - q).array() / q.array().abs().max(1.0)).abs().maxCoeff();
    std::printf("tolerance %.0e: %ld steps, %ld evaluations, %ld matrices, error %.1e\n", tolerance,
                r.counts.steps, r.counts.evaluations, r.counts.jacobians, error);
    // Local errors of order 3: the global error goes with tolerance^(2/3), 21 for two decades.
    EXPECT_LT(error, 0.15 * before) << tolerance;
    before = error;
  }
  EXPECT_LT(before, 1e-4);
}

TEST(GeneralisedAlpha, KeepsTheEnergyOfAChainForRhoOneAndDampsItsHighModesForRhoZero) {
  SpringChain m(2);  // modes (1, 1) and (1, -1)
  State s = make_state(m);
  s.p << 1.0, -1.0;
  const double h = 20.0 / m.omega(2);
  SolverOptions o = options(200 * h, 1e-6, h);
  o.rho_inf = 1.0;
  RunResult r = simulate(m, s, o);
  // The trapezoidal rule keeps the energy of a linear system exactly: 200 steps of round-off, and Newton's
  // tolerance (1e-8) in each.
  EXPECT_NEAR(m.energy(r.state, r.v_dot, *m.make_scratch()).kinetic +
                  m.energy(r.state, r.v_dot, *m.make_scratch()).potential,
              0.5 * 300.0 * 6.0, 1e-5 * 900.0);
  o.rho_inf = 0.0;
  r = simulate(m, s, o);
  // omega h = 20: two steps of rho = 0 at infinite frequency would leave nothing; here each leaves about 0.3.
  EXPECT_LT(r.state.p.norm(), 1e-6);
}

TEST(GeneralisedAlpha, TurnsABodyThroughEveryAttitudeWithOrderTwo) {
  double error[2];
  for (int k = 0; k < 2; ++k)
    error[k] = momentum_error_of_a_tumbling_body(options(3.0, 1e-10, 2e-3 / (1 << k)));
  EXPECT_LT(error[0], 1e-2);
  EXPECT_GT(error[0] / error[1], 3.0);
}

TEST(GeneralisedAlpha, FindsSwitchesAsExactlyAsItsSteps) {
  finds_the_switches_of_a_bounce("generalised_alpha");
}

}  // namespace
}  // namespace flexura::mbs::test
