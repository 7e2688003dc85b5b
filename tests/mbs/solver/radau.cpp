// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "mbs/solver/accelerations.hpp"
#include "mbs/solver/assemble.hpp"
#include "mbs/solver/run.hpp"
#include "tests/mbs/solver/simple.hpp"

namespace flexura::mbs::test {
namespace {

SolverOptions options(double end_time, double tolerance) {
  SolverOptions o;
  o.method = "radau";
  o.end_time = o.output_step = end_time;
  o.tolerance = tolerance;
  return o;
}

RunResult simulate(const Equations& m, State s, const SolverOptions& o) {
  Eigen::VectorXd v_dot;
  assemble(m, s, v_dot);
  return run(m, s, v_dot, o);
}

TEST(Radau, ErrorFallsWithTheTolerance) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << -1.0, 0.0;
  // IFToMM A01 at t = 1 s, printed to 1e-12.
  const Eigen::Vector2d exact(.986291751132, -.165010853126);
  double error[3];
  for (int k = 0; k < 3; ++k) {
    const double tolerance = std::pow(10.0, -5 - 2 * k);
    const RunResult r = simulate(m, s, options(1.0, tolerance));
    ASSERT_TRUE(r.complete) << r.stopped_because;
    error[k] = (r.state.p - exact).norm();
    EXPECT_LT(error[k], 10.0 * tolerance);
    EXPECT_LT(r.peak_position_drift, 10.0 * tolerance);
  }
  // At least as the third-order estimate that controls the step: tolerance^(2/3), 460 over four decades, less
  // what single steps happen to be.
  EXPECT_GT(error[0] / error[2], 30.0);
}

TEST(Radau, TurnsABodyThroughEveryAttitude) {
  const FreeBody m;
  State s = make_state(m);
  s.p << 0, 0, 0, 1, 0, 0, 0;
  s.v << 1.0, -2.0, 0.5, 0.01, 8.0, -0.02;
  const Eigen::Vector3d L = m.angular_momentum(s);
  const RunResult r = simulate(m, s, options(3.0, 1e-8));
  ASSERT_TRUE(r.complete) << r.stopped_because;
  // Four turns, some hundred steps of 1e-8 each.
  EXPECT_LT((m.angular_momentum(r.state) - L).norm() / L.norm(), 1e-6);
}

TEST(Radau, FindsSwitches) {
  const BouncingBall m;
  State s = make_state(m);
  s.p << 1.0;
  const RunResult r = simulate(m, s, options(0.6, 1e-9));
  ASSERT_TRUE(r.complete) << r.stopped_because;
  ASSERT_GE(r.events.size(), 2u);
  EXPECT_NEAR(r.events[0].t, std::sqrt(2.0 / m.g), 1e-8);
  // Contact for about half a period of 2 pi sqrt(m / k) = 31 ms.
  EXPECT_NEAR(r.events[1].t - r.events[0].t, M_PI * std::sqrt(m.mass / m.stiffness), 3e-4);
}

}  // namespace
}  // namespace flexura::mbs::test
