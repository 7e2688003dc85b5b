// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/integrators/background_queue.hpp"
#include "mbs/solver/integrators/known_times.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "tests/mbs/solver/flexible_engine.hpp"
#include "tests/mbs/solver/rows.hpp"
#include "tests/mbs/solver/simple.hpp"
#include "tests/mbs/started.hpp"
#include "tests/mbs/test_folder.hpp"

/// Rows that a second thread makes.
namespace flexura::mbs::test {
namespace {

TEST(BackgroundQueue, WorksOffEverythingInOrder) {
  std::vector<int> seen;
  std::thread::id by;
  BackgroundQueue<int> items(
      [&](int& i) {
        seen.push_back(i);
        if (i == 0) by = std::this_thread::get_id();
      },
      true);
  // In two parts, neither a whole number of batches.
  for (int i = 0; i < 1003; ++i) {
    items.next() = i;
    items.push();
    if (i == 500) items.drain();
    if (i == 500) {
      EXPECT_EQ(seen.size(), 501u);
    }
  }
  items.drain();
  std::vector<int> all(1003);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(seen, all);
  EXPECT_NE(by, std::this_thread::get_id());
}

TEST(BackgroundQueue, FinishesWhatWasHandedOver) {
  std::vector<int> seen;
  {
    BackgroundQueue<int> items([&](int& i) { seen.push_back(i); }, true);
    for (int i = 0; i < 400; ++i) {
      items.next() = i;
      items.push();
    }
  }
  // At most 127 wait for the second thread; whoever wants those drains.
  EXPECT_GE(seen.size(), 400u - 127u);
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], static_cast<int>(i));
}

TEST(BackgroundQueue, ThrowsWhereTheFirstThreadIs) {
  for (const bool beside : {false, true}) {
    SCOPED_TRACE(beside);
    std::vector<int> seen;
    BackgroundQueue<int> items(
        [&](int& i) {
          if (i == 70) throw std::runtime_error("70 is too many");
          seen.push_back(i);
        },
        beside);
    int pushed = 0;
    const auto push_all = [&] {
      for (; pushed < 1000; ++pushed) {
        items.next() = pushed;
        items.push();
      }
      items.drain();
    };
    EXPECT_THROW(push_all(), std::runtime_error);
    EXPECT_EQ(seen.size(), 70u);
    EXPECT_LE(pushed, 70 + 2 * 128);  // soon
    items.next() = 2000;
    items.push();
    items.drain();
    EXPECT_EQ(seen.back(), 2000);
  }
}

void expect_same_beside(const Equations& eq, const State& s, const Eigen::VectorXd& v_dot,
                        const SolverOptions& o) {
  Rows here, beside;
  RunCallbacks callbacks = beside.callbacks();
  callbacks.rows_beside = true;
  const RunResult a = run(eq, s, v_dot, o, here.callbacks()), b = run(eq, s, v_dot, o, callbacks);
  ASSERT_TRUE(a.complete) << a.stopped_because;
  ASSERT_TRUE(b.complete) << b.stopped_because;
  EXPECT_GT(a.counts.steps, 20);
  expect_same_to_the_bit(here, beside);
  EXPECT_EQ(a.state.p, b.state.p);
  EXPECT_EQ(a.energy.error(), b.energy.error());
  EXPECT_EQ(a.largest_energy_error, b.largest_energy_error);
  EXPECT_EQ(a.peak_position_drift, b.peak_position_drift);
  EXPECT_EQ(a.peak_velocity_drift, b.peak_velocity_drift);
  EXPECT_EQ(a.events.size(), b.events.size());
}

class RowsBeside : public ::testing::TestWithParam<const char*> {
 protected:
  SolverOptions options(double end_time, double output_step, double fixed_step) const {
    SolverOptions o;
    o.method = GetParam();
    o.end_time = end_time;
    o.output_step = output_step;
    if (o.method == "generalised_alpha") o.fixed_step = fixed_step;
    return o;
  }
};

TEST_P(RowsBeside, OfAFlexibleLoopAreTheSameToTheBit) {
  const Started start(flexible_engine(true));
  SolverOptions o = options(0.05, 2e-4, 1e-4);
  o.tolerance = 1e-5;
  expect_same_beside(start.m, start.s, start.v_dot, o);
}

// Switches, whose jumps enter the book between the steps.
TEST_P(RowsBeside, OfABallOnItsFloorAreTheSameToTheBit) {
  const BouncingBall m;
  State s = make_state(m);
  s.p << 1.0;
  Eigen::VectorXd v_dot;
  assemble(m, s, v_dot);
  expect_same_beside(m, s, v_dot, options(1.5, 0.01, 1e-3));
}

TEST_P(RowsBeside, ThatCannotBeWrittenEndTheRun) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << -1.0, 0.0;
  Eigen::VectorXd v_dot;
  assemble(m, s, v_dot);
  int rows = 0;
  double t_steps = 0.0;
  RunCallbacks callbacks;
  callbacks.rows_beside = true;
  callbacks.row = [&](const State&, const Eigen::VectorXd&, const EnergyAccount&) {
    if (++rows == 30) throw std::runtime_error("the disk is full");
  };
  callbacks.progress = [&](double t, double) { t_steps = t; };
  EXPECT_THROW(run(m, s, v_dot, options(100.0, 0.01, 1e-3), callbacks), std::runtime_error);
  EXPECT_EQ(rows, 30);
  EXPECT_LT(t_steps, 50.0);  // soon, not at the end
}

INSTANTIATE_TEST_SUITE_P(Integrators, RowsBeside,
                         ::testing::Values("ida", "radau", "generalised_alpha", "runge_kutta"),
                         [](const auto& info) { return std::string(info.param); });

// Looks come in turn with rows, at their own times, with states as good as those of rows: on the circle to round-off.
TEST(Looks, ComeInTurnWithRows) {
  const CartesianPendulum pendulum;
  for (const bool beside : {false, true}) {
    State start = make_state(pendulum);
    start.p << 1.0, 0.0;
    Eigen::VectorXd a;
    assemble(pendulum, start, a);
    SolverOptions options;
    options.end_time = 1.0;
    options.output_step = 0.1;
    std::vector<double> looks, all;
    RunCallbacks callbacks;
    callbacks.rows_beside = beside;
    callbacks.row = [&](const State& s, const Eigen::VectorXd&, const EnergyAccount&) { all.push_back(s.t); };
    callbacks.look = [&](const State& s, const Eigen::VectorXd& v_dot) {
      all.push_back(s.t);
      looks.push_back(s.t);
      EXPECT_NEAR(s.p.squaredNorm(), 1.0, 1e-14) << s.t;
      EXPECT_NEAR(s.p.dot(v_dot) + s.v.squaredNorm(), 0.0, 1e-9)
          << s.t;  // of velocities that are right to 1e-10
    };
    // Before the start, at a row and behind the end there is nothing to look at.
    callbacks.look_at = {-1.0, 0.0, 0.05, 0.0500001, 0.1, 0.123, 0.999, 1.0, 2.0};
    ASSERT_TRUE(run(pendulum, start, a, options, callbacks).complete);
    EXPECT_EQ(looks, (std::vector<double>{0.05, 0.0500001, 0.123, 0.999}));
    EXPECT_EQ(all.size(), 11u + 4u);
    EXPECT_TRUE(std::ranges::is_sorted(all));
    looks.clear();
    callbacks.look_at.clear();
    callbacks.wants_look = [](double begin, double end) { return begin < 0.5 && end >= 0.5; };
    ASSERT_TRUE(run(pendulum, start, a, options, callbacks).complete);
    EXPECT_EQ(looks.size(), 1u);
  }
}

class KnownLooks : public TestFolder {
 protected:
  // Of a mass that is pushed so for ten seconds, with rows 10 ms apart.
  KnownTimes::Looks looks(const std::string& push, std::size_t most = 400) const {
    const PreparedMechanism run = prepare(file(R"toml(
gravity = [0, 0, 0]
[body.m]
mass = 1
inertia = [1, 1, 1]
[joint.s]
type = "prismatic"
from = "ground"
to = "m"
[force.f]
type = "joint_force"
joint = "s"
value = ")toml" + push + "\"\n[solver]\nend_time = 10\noutput_step = 0.01\n"));
    return KnownTimes::looks(*run.mechanism, run.options, 0.01, most);
  }
  // The integral of sin^2 from a to b, 0 elsewhere, by the trapezoidal rule over the looks, which begin and end at 0.
  static double impulse(const std::vector<double>& t, double a, double b) {
    const auto f = [&](double x) {
      const double sine = std::sin(std::numbers::pi * (x - a) / (b - a));
      return x > a && x < b ? sine * sine : 0.0;
    };
    double sum = 0.0;
    for (std::size_t i = 1; i < t.size(); ++i) sum += 0.5 * (t[i] - t[i - 1]) * (f(t[i]) + f(t[i - 1]));
    return sum;
  }
};

TEST_F(KnownLooks, SeeTheWholeImpulseOfShortPulses) {
  for (const double length : {1e-3, 1e-5, 1e-9}) {
    const auto seen =
        looks(fmt::format("t > 5 && t < {0:.17g} ? sin(pi*(t-5)/({0:.17g}-5))^2 : 0", 5.0 + length));
    EXPECT_TRUE(seen.is_all) << length;
    EXPECT_LT(seen.t.size(), 100u) << length;
    // Half its length; a load that is told to 1 % tells the estimate.
    EXPECT_NEAR(impulse(seen.t, 5.0, 5.0 + length), 0.5 * length, 1e-2 * length) << length;
  }
}

TEST_F(KnownLooks, AreNoneWhereRowsShowAll) {
  EXPECT_TRUE(looks("10*sin(2*pi*t)").t.empty());
  // A jump is seen from its moment on.
  const auto jump = looks("t > 5 ? 1 : 0");
  ASSERT_FALSE(jump.t.empty());
  EXPECT_LT(jump.t.back(), 5.01);
  EXPECT_NEAR(jump.t.front(), 5.0, 1e-12);
}

TEST_F(KnownLooks, SayWhereTheyAreNotAll) {
  const auto seen = looks("sin(2*pi*1000*t)");
  EXPECT_FALSE(seen.is_all);
  EXPECT_LE(seen.t.size(), 400u);
  EXPECT_FALSE(looks("t > 5 && t < 5.001 ? 1 : 0", 5).is_all);
}

}  // namespace
}  // namespace flexura::mbs::test
