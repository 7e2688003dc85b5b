// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/solver/method_runs.hpp"

namespace flexura::mbs::test {
namespace {

TEST(Radau, ErrorFallsWithTheTolerance) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << -1.0, 0.0;
  // IFToMM A01 at t = 1 s, printed to 1e-12.
  const Eigen::Vector2d exact(.986291751132, -.165010853126);
  double error[3];
  for (int k = 0; k < 3; ++k) {
    const double tolerance = std::pow(10.0, -6 - 2 * k);
    const RunResult r = simulate(m, s, until(1.0, tolerance, "radau"));
    error[k] = (r.state.p - exact).norm();
    // The third-order estimate of a step is held to this; what the fifth-order step leaves is a part of it.
    const double allowed = 0.1 * std::pow(tolerance, 2.0 / 3.0);
    EXPECT_LT(error[k], allowed);
    EXPECT_LT(r.peak_position_drift, allowed);
  }
  // At least as that estimate: tolerance^(2/3), 460 over four decades, less what single steps happen to be.
  EXPECT_GT(error[0] / error[2], 30.0);
}

TEST(Radau, TurnsABodyThroughEveryAttitude) {
  // Four turns, some hundred steps of 1e-8 each.
  EXPECT_LT(momentum_error_of_a_tumbling_body(until(3.0, 1e-8, "radau")), 1e-6);
}

TEST(Radau, FindsSwitches) {
  finds_the_switches_of_a_bounce("radau");
}

}  // namespace
}  // namespace flexura::mbs::test
