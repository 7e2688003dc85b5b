// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run_memory.hpp"
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

// A file's numbers are anybody's: no length and no count of a history may lead out of its reader's memory, and a
// value that is not finite is refused.  Which value a counter has is the file's business; that the run then is another
// is what its checksum is for.
TEST_P(Continued, AHistoryThatWasChangedIsRefusedOrHarmless) {
  BouncingBall ball;
  CartesianPendulum pendulum;
  for (const Equations* m :
       {static_cast<const Equations*>(&ball), static_cast<const Equations*>(&pendulum)}) {
    State s = make_state(*m);
    s.p.setZero();
    s.p(0) = m == &ball ? 1.0 : -1.0;
    Eigen::VectorXd v_dot;
    assemble(*m, s, v_dot);
    SolverOptions o = options(0.5);
    o.stop_time = 0.21;
    const Continuation good = run(*m, s, v_dot, o).continuation;
    o.stop_time = 0.0;
    o.max_steps = 1;
    const auto refused = [&](const Continuation& bad) {
      try {
        run(*m, bad, o);
        return false;
      } catch (const std::invalid_argument&) {
        return true;
      } catch (const std::runtime_error&) {
        return false;
      }
    };
    EXPECT_FALSE(refused(good));
    for (std::size_t i = 0; i < good.history.size(); ++i) {
      Continuation bad = good;
      bad.history.erase(bad.history.begin() + static_cast<long>(i));
      EXPECT_TRUE(refused(bad)) << "without entry " << i;
      bad = good;
      bad.history.insert(bad.history.begin() + static_cast<long>(i), 1.0);
      EXPECT_TRUE(refused(bad)) << "with one more at " << i;
      for (const double x : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        bad = good;
        bad.history[i] = x;
        EXPECT_TRUE(refused(bad)) << x << " at " << i;
      }
      for (const double x : {-1.0, 0.0, 3.0, 1e9, -1e300}) {
        bad = good;
        bad.history[i] = x;
        refused(bad);  // only that it comes back
      }
    }
    for (const long next : {-5L, 0L, good.next_row - 1, good.next_row + 2, 1000000L}) {
      Continuation bad = good;
      bad.next_row = next;
      EXPECT_TRUE(refused(bad)) << "next row " << next;
    }
    Continuation bad = good;
    bad.state.p(0) = std::nan("");
    EXPECT_TRUE(refused(bad));
    bad = good;
    bad.v_dot.resize(0);
    EXPECT_TRUE(refused(bad));
    bad = good;
    bad.state.t = 0.6;
    EXPECT_TRUE(refused(bad));
  }
}

// Handed out between two steps, the run's memory leaves the run as it is; what goes on from any of them is the same
// run, with the same figures.
TEST_P(Continued, AnyMemoryOfARunLeadsToItsEndToTheBit) {
  const BouncingBall m;
  State s = make_state(m);
  s.p << 1.0;
  Eigen::VectorXd v_dot;
  assemble(m, s, v_dot);
  const SolverOptions o = options(1.5);
  Rows whole, watched;
  const RunResult unbroken = run(m, s, v_dot, o, whole.callbacks());
  std::vector<RunMemory> memories;
  int steps = 0;
  Remembering remembering;
  remembering.wanted = [&] { return ++steps % 7 == 0; };
  remembering.take = [&](const RunMemory& memory) { memories.push_back(memory); };
  const RunResult again = run(m, s, v_dot, o, watched.callbacks(), remembering);
  test::expect_same_to_the_bit(watched, whole);
  EXPECT_EQ(again.counts.evaluations, unbroken.counts.evaluations);
  ASSERT_GT(memories.size(), 3u);
  for (const RunMemory& memory : memories) {
    Rows parts;
    const RunResult rest = run(m, memory, o, parts.callbacks(), Remembering{});
    EXPECT_TRUE(rest.complete) << rest.stopped_because;
    EXPECT_EQ(rest.state.p, unbroken.state.p);
    EXPECT_EQ(rest.state.v, unbroken.state.v);
    EXPECT_EQ(rest.counts.steps, unbroken.counts.steps);
    EXPECT_EQ(rest.counts.evaluations, unbroken.counts.evaluations);
    EXPECT_EQ(rest.counts.jacobians, unbroken.counts.jacobians);
    EXPECT_EQ(rest.counts.error_failures, unbroken.counts.error_failures);
    EXPECT_EQ(rest.counts.newton_failures, unbroken.counts.newton_failures);
    EXPECT_EQ(rest.events.size(), unbroken.events.size());
    EXPECT_EQ(rest.energy.error(), unbroken.energy.error());
    EXPECT_EQ(rest.largest_energy_error, unbroken.largest_energy_error);
    EXPECT_EQ(rest.peak_position_drift, unbroken.peak_position_drift);
  }
}

INSTANTIATE_TEST_SUITE_P(Integrators, Continued,
                         ::testing::Values("ida", "radau", "generalised_alpha", "runge_kutta"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace flexura::mbs::test
