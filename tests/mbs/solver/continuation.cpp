// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mbs/solver/accelerations.hpp"
#include "mbs/solver/assemble.hpp"
#include "mbs/solver/run.hpp"
#include "tests/mbs/solver/planar.hpp"
#include "tests/mbs/solver/rows.hpp"
#include "tests/mbs/solver/simple.hpp"

namespace flexura::mbs::test {
namespace {

class Continued : public ::testing::TestWithParam<std::string> {
 protected:
  // Cut after the step that reaches `cut`, and gone on by an integrator that knows only the continuation.
  void expect_same_to_the_bit(const Equations& m, State s, SolverOptions o, double cut) {
    Eigen::VectorXd v_dot;
    assemble(m, s, v_dot);
    Rows whole, parts;
    const RunResult unbroken = run(m, s, v_dot, o, whole.callbacks());
    ASSERT_TRUE(unbroken.complete) << unbroken.stopped_because;
    o.stop_time = cut;
    const RunResult first = run(m, s, v_dot, o, parts.callbacks());
    ASSERT_FALSE(first.complete);
    ASSERT_THAT(first.stopped_because, ::testing::HasSubstr("stop_time"));
    ASSERT_GT(first.counts.steps, 5);
    o.stop_time = 0.0;
    const RunResult second = run(m, first.continuation, o, parts.callbacks());
    ASSERT_TRUE(second.complete) << second.stopped_because;
    test::expect_same_to_the_bit(parts, whole);
    EXPECT_EQ(second.state.p, unbroken.state.p);
  }
  SolverOptions options(double end_time) const {
    SolverOptions o;
    o.method = GetParam();
    o.end_time = end_time;
    o.output_step = end_time / 20;
    if (o.method == "generalised_alpha") o.fixed_step = end_time / 1000;
    return o;
  }
};

TEST_P(Continued, PendulumIsTheUnbrokenRunToTheBit) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << -1.0, 0.0;
  expect_same_to_the_bit(m, s, options(2.0), 0.83);
}

TEST_P(Continued, AndrewsMechanismIsTheUnbrokenRunToTheBit) {
  const PlanarMechanism m = andrews();
  State s = make_state(m);
  s.p << -0.0617138900142764496, 0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
      -0.222668390165885885, 1.23054744454982119;
  expect_same_to_the_bit(m, s, options(0.01), 0.006);
}

TEST_P(Continued, BallOnItsFloorIsTheUnbrokenRunToTheBit) {
  const BouncingBall m;
  State s = make_state(m);
  s.p << 1.0;
  // Cut within the first contact, which lasts from 0.452 s to 0.468 s.
  expect_same_to_the_bit(m, s, options(1.5), 0.46);
}

TEST_P(Continued, RunGoesOnBeyondItsEnd) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << -1.0, 0.0;
  Eigen::VectorXd v_dot;
  assemble(m, s, v_dot);
  SolverOptions o = options(0.5);
  o.tolerance = 1e-9;
  const RunResult first = run(m, s, v_dot, o);
  ASSERT_TRUE(first.complete) << first.stopped_because;
  o.end_time = 1.0;
  const RunResult second = run(m, first.continuation, o);
  ASSERT_TRUE(second.complete) << second.stopped_because;
  // IFToMM A01 at t = 1 s; order 2 at tolerance 1e-9 leaves about 1e-6 in a second.
  EXPECT_LT((second.state.p - Eigen::Vector2d(.986291751132, -.165010853126)).norm(), 1e-5);
}

TEST_P(Continued, OtherMechanismAndOtherIntegratorAreRefused) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << -1.0, 0.0;
  Eigen::VectorXd v_dot;
  assemble(m, s, v_dot);
  SolverOptions o = options(0.1);
  const RunResult first = run(m, s, v_dot, o);
  EXPECT_THROW(run(BouncingBall(), first.continuation, o), std::invalid_argument);
  o.method = GetParam() == "ida" ? "runge_kutta" : "ida";
  EXPECT_THROW(run(m, first.continuation, o), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(Integrators, Continued,
                         ::testing::Values("ida", "radau", "generalised_alpha", "runge_kutta"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace flexura::mbs::test
