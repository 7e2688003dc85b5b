// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/solver/simple.hpp"

/// Runs of small systems that the tests of several integrators make.
namespace flexura::mbs::test {

inline SolverOptions until(double end_time, double tolerance, const std::string& method = "ida") {
  SolverOptions o;
  o.method = method;
  o.end_time = o.output_step = end_time;
  o.tolerance = tolerance;
  return o;
}

inline RunResult simulate(const Equations& m, State s, const SolverOptions& o) {
  Eigen::VectorXd v_dot;
  assemble(m, s, v_dot);
  const RunResult r = run(m, s, v_dot, o);
  EXPECT_TRUE(r.complete) << r.stopped_because;
  return r;
}

/// A ball falls, strikes and leaves the ground: both events against their times.
inline void finds_the_switches_of_a_bounce(const std::string& method) {
  const BouncingBall m;
  State s = make_state(m);
  s.p << 1.0;
  const RunResult r = simulate(m, s, until(0.6, 1e-9, method));
  ASSERT_GE(r.events.size(), 2u);
  // Free fall is a parabola, which the methods follow exactly: Newton's tolerance is left.
  EXPECT_NEAR(r.events[0].t, std::sqrt(2.0 / m.g), 1e-8);
  // Contact for about half a period of 2 pi sqrt(m / k) = 31 ms.
  EXPECT_NEAR(r.events[1].t - r.events[0].t, M_PI * std::sqrt(m.mass / m.stiffness), 3e-4);
}

/// A free body that tumbles: |L - L_0| / |L_0| of its angular momentum at the end.
inline double momentum_error_of_a_tumbling_body(const SolverOptions& o) {
  const FreeBody m;
  State s = make_state(m);
  s.p << 0, 0, 0, 1, 0, 0, 0;
  s.v << 1.0, -2.0, 0.5, 0.01, 8.0, -0.02;
  const Eigen::Vector3d L = m.angular_momentum(s);
  return (m.angular_momentum(simulate(m, s, o).state) - L).norm() / L.norm();
}

}  // namespace flexura::mbs::test
