// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/solver/planar.hpp"
#include "tests/mbs/solver/simple.hpp"

namespace flexura::mbs::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct Recorded {
  RunResult result;
  std::vector<State> rows;
};

Recorded simulate(const Equations& m, State s, SolverOptions options, const AssembleOptions& assembly = {}) {
  Eigen::VectorXd v_dot;
  s.t = options.start_time;
  assemble(m, s, v_dot, assembly);
  Recorded out;
  RunCallbacks callbacks;
  callbacks.row = [&](const State& row, const Eigen::VectorXd&, const EnergyAccount&) {
    out.rows.push_back(row);
  };
  out.result = run(m, s, v_dot, options, callbacks);
  return out;
}

SolverOptions until(double end_time, double output_step, double tolerance) {
  SolverOptions o;
  o.end_time = end_time;
  o.output_step = output_step;
  o.tolerance = tolerance;
  return o;
}

TEST(Dynamics, PendulumFollowsTheExactMotion) {
  // IFToMM A01, twelve digits from the equation in the angle.
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << -1.0, 0.0;
  const Recorded r = simulate(m, s, until(10.0, 1.0, 1e-10));
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  ASSERT_EQ(r.rows.size(), 11u);
  auto error = [&](int row, double x, double y) {
    return std::hypot(r.rows[row].p(0) - x, r.rows[row].p(1) - y);
  };
  // Judged at 1e-6; tolerance 1e-10 in each of some 2000 steps.
  EXPECT_LT(error(1, .986291751132, -.165010853126), 1e-6);
  EXPECT_LT(error(5, -.942305435044, -.334754338414), 1e-6);
  EXPECT_LT(error(10, -.275087462576, -.961419205099), 1e-6);
  // The library's own criterion is 5e-5 J.
  EXPECT_LT(r.result.largest_energy_error, 1e-6);
  // Closed to round-off at the end of every step.
  EXPECT_LT(r.result.peak_position_drift, 1e-9);
  EXPECT_LT(r.result.peak_velocity_drift, 1e-8);
  // Rod force from the energy: lambda = v^2 - g y = -3 g y for L = m = 1 and a start at y = 0.
  EXPECT_NEAR(r.rows[10].lambda(0), 3.0 * 9.81 * .961419205099, 1e-4);
}

TEST(Dynamics, AndrewsMechanismReachesThePublishedEndStateAtEveryTolerance) {
  const PlanarMechanism m = andrews();
  State s = make_state(m);
  s.p << -0.0617138900142764496, 0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
      -0.222668390165885885, 1.23054744454982119;
  Eigen::VectorXd q(7), v(7), lambda(6);
  q << 15.81077119629904, -15.75637105984298, .04082224013073101, -.5347301163226948, .5244099658805304,
      .5347301163226948, 1.048080741042263;
  v << 1139.920302151208, -1424.379294994111, 11.03291221937134, 19.29337464421385, .5735699284790808,
      -19.29337464421385, .3231791658026955;
  lambda << 199.1753333731910, -29.75531228015052, 23.06654119098399, 31.45271365475927, 22.64249232082739,
      11.61740700019673;
  double before = 1.0;
  for (const double tolerance : {1e-6, 1e-8, 1e-10}) {
    const Recorded r = simulate(m, s, until(0.03, 0.01, tolerance));
    ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
    const double error = ((r.result.state.p - q).array() / q.array().abs().max(1.0)).abs().maxCoeff();
    // A method that controls its local error follows the tolerance; two decades of it must gain at least a
    // factor 10.
    EXPECT_LT(error, 0.1 * before);
    before = error;
  }
  EXPECT_LT(before, 1e-7);
}

TEST(Dynamics, WindowsPassTheirSingularPositions) {
  // IFToMM A02: where the uprights lie flat the loops lose rank for an instant.
  const PlanarMechanism m = windows(2);
  State s = make_state(m);
  s.p << M_PI / 2, M_PI / 2, M_PI / 2, 0.0, 0.0;
  s.v << -1.0, -1.0, -1.0, 0.0, 0.0;
  const Recorded r = simulate(m, s, until(10.0, 1.0, 1e-8));
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  auto error = [&](int row, double x, double y) {
    return std::hypot(std::cos(r.rows[row].p(0)) - x, std::sin(r.rows[row].p(0)) - y);
  };
  // Each pass of a singular position multiplies what the steps leave (1e-8) by the condition it is left with;
  // 1.6e-5 to 2.5e-5 are reached by 10 s, with the compiler's round-off.
  EXPECT_LT(error(1, -.195020301949, -.980799205662), 1e-4);
  EXPECT_LT(error(2, .057815795768, .998327267863), 1e-4);
  EXPECT_LT(error(5, -.811310461000, -.584615545356), 1e-4);
  EXPECT_LT(error(10, .328458111534, .944518538181), 1e-4);
  // The library asks for 0.1 J.
  EXPECT_LT(r.result.largest_energy_error, 1e-4);
}

TEST(Dynamics, RedundantWindowsMoveAlike) {
  PlanarMechanism m = windows(2);
  const auto rows = m.constraints;
  for (const auto& c : rows) m.constraints.push_back(c);
  State s = make_state(m);
  s.p << M_PI / 2, M_PI / 2, M_PI / 2, 0.0, 0.0;
  s.v << -1.0, -1.0, -1.0, 0.0, 0.0;
  const Recorded r = simulate(m, s, until(2.0, 1.0, 1e-6));
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  EXPECT_NEAR(std::cos(r.rows[2].p(0)), .057815795768, 1e-3);
}

TEST(Dynamics, FreeBodyKeepsItsMomentaThroughEveryAttitude) {
  const FreeBody m;
  State s = make_state(m);
  s.p << 0, 0, 0, 1, 0, 0, 0;
  s.v << 1.0, -2.0, 0.5, 0.01, 8.0, -0.02;  // about the middle axis: it turns over again and again
  const Eigen::Vector3d L = m.angular_momentum(s);
  const Recorded r = simulate(m, s, until(10.0, 0.05, 1e-9));
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  double lowest = 1.0;
  for (const State& row : r.rows) {
    // tolerance 1e-9 a step, some 4000 steps, error of the attitude growing with the time.
    EXPECT_LT((m.angular_momentum(row) - L).norm(), 1e-6 * L.norm());
    EXPECT_LT((row.v.head<3>() - s.v.head<3>()).norm(), 1e-12);
    lowest = std::min(lowest, (FreeBody::attitude(row.p) * Eigen::Vector3d::UnitY()).y());
  }
  EXPECT_LT(lowest, -0.99);  // the body's axis does turn over
  EXPECT_LT(r.result.largest_energy_error, 1e-6 * 8.0);
  // x = v t exactly.
  EXPECT_LT((r.result.state.p.head<3>() - 10.0 * s.v.head<3>()).norm(), 1e-8);
}

// First positive zero of the ball's motion in contact: m z'' + d z' + k z = -m g, z(0) = 0, z'(0) = v.
double contact_time(const BouncingBall& b, double v, double* v_out) {
  const double delta = b.damping / (2.0 * b.mass), omega = std::sqrt(b.stiffness / b.mass - delta * delta);
  const double z_s = -b.mass * b.g / b.stiffness;  // z = z_s + e^(-delta t) (A cos + B sin)
  const double A = -z_s, B = (v + delta * A) / omega;
  auto z = [&](double t) {
    return z_s + std::exp(-delta * t) * (A * std::cos(omega * t) + B * std::sin(omega * t));
  };
  double low = 0.5 * M_PI / omega, high = 1.5 * M_PI / omega;  // deep inside, and back above the floor
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (z(middle) < 0.0 ? low : high) = middle;
  }
  const double e = std::exp(-delta * low), c = std::cos(omega * low), n = std::sin(omega * low);
  *v_out = e * ((omega * B - delta * A) * c - (omega * A + delta * B) * n);
  return low;
}

TEST(Dynamics, BallOnALinearContactLawSwitchesAtTheExactTimes) {
  const BouncingBall m;
  State s = make_state(m);
  s.p << 1.0;
  const Recorded r = simulate(m, s, until(3.0, 0.1, 1e-10));
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  double t = std::sqrt(2.0 / m.g), v = -m.g * t;
  ASSERT_GE(r.result.events.size(), 6u);
  for (std::size_t k = 0; k < 6; k += 2) {
    EXPECT_NEAR(r.result.events[k].t, t, 1e-8) << "touch-down " << k / 2;
    double v_up = 0.0;
    t += contact_time(m, v, &v_up);
    EXPECT_NEAR(r.result.events[k + 1].t, t, 1e-8) << "lift-off " << k / 2;
    t += 2.0 * v_up / m.g;
    v = -v_up;
  }
  // 1e-10 of the velocity in each of some 2000 steps at worst.
  EXPECT_LT(r.result.energy.relative_error(), 2e-7);
}

TEST(Dynamics, BallWithRestitutionBouncesAtTheExactTimesAndItsLastBouncesAreRefused) {
  BouncingBall m;
  m.compliant = false;
  State s = make_state(m);
  s.p << 1.0;
  Recorded r = simulate(m, s, until(3.0, 0.1, 1e-10));
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  const double t_1 = std::sqrt(2.0 / m.g);
  double t = t_1, pause = 2.0 * t_1;
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_NEAR(r.result.events[k].t, t, 1e-8) << "bounce " << k;
    EXPECT_TRUE(r.result.events[k].jumped);
    pause *= m.restitution;
    t += pause;
  }
  // All bounces are over at t_1 (1 + e) / (1 - e) = 4.06 s.
  r = simulate(m, s, until(6.0, 0.1, 1e-8));
  EXPECT_FALSE(r.result.complete);
  EXPECT_THAT(r.result.stopped_because, HasSubstr("floor.contact"));
  EXPECT_NEAR(r.result.state.t, t_1 * 9.0, 1e-3);
}

TEST(Dynamics, ExplicitIntegratorAgreesWithTheExactSolutions) {
  SolverOptions o = until(10.0, 1.0, 1e-8);
  o.method = "runge_kutta";
  const CartesianPendulum pendulum;
  State s = make_state(pendulum);
  s.p << -1.0, 0.0;
  Recorded r = simulate(pendulum, s, o);
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  // Interpolated rows as well as the end; 1e-8 in each of 600 steps.
  EXPECT_LT((r.rows[1].p - Eigen::Vector2d(.986291751132, -.165010853126)).norm(), 5e-6);
  EXPECT_LT((r.rows[10].p - Eigen::Vector2d(-.275087462576, -.961419205099)).norm(), 5e-6);
  // Steps are projected to round-off, rows between them are closed to 1e-11 of the motion (LoopCloser).
  EXPECT_LT(r.result.peak_position_drift, 1e-11);
  EXPECT_NEAR(r.rows[10].lambda(0), 3.0 * 9.81 * .961419205099, 1e-4);

  const PlanarMechanism squeezer = andrews();
  s = make_state(squeezer);
  s.p << -0.0617138900142764496, 0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
      -0.222668390165885885, 1.23054744454982119;
  o.end_time = 0.03;
  o.output_step = 0.01;
  r = simulate(squeezer, s, o);
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  Eigen::VectorXd q(7);
  q << 15.81077119629904, -15.75637105984298, .04082224013073101, -.5347301163226948, .5244099658805304,
      .5347301163226948, 1.048080741042263;
  EXPECT_LT(((r.result.state.p - q).array() / q.array().abs().max(1.0)).abs().maxCoeff(), 1e-7);

  const PlanarMechanism frames = windows(2);
  s = make_state(frames);
  s.p << M_PI / 2, M_PI / 2, M_PI / 2, 0.0, 0.0;
  s.v << -1.0, -1.0, -1.0, 0.0, 0.0;
  o.end_time = 10.0;
  r = simulate(frames, s, o);
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  EXPECT_NEAR(std::cos(r.result.state.p(0)), .328458111534, 1e-5);

  const BouncingBall ball;
  s = make_state(ball);
  s.p << 1.0;
  o.tolerance = 1e-10;
  o.end_time = 1.0;
  r = simulate(ball, s, o);
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  ASSERT_GE(r.result.events.size(), 2u);
  double v_up = 0.0;
  const double t_down = std::sqrt(2.0 / ball.g);
  EXPECT_NEAR(r.result.events[0].t, t_down, 1e-10);
  EXPECT_NEAR(r.result.events[1].t, t_down + contact_time(ball, -ball.g * t_down, &v_up), 1e-8);
}

TEST(Dynamics, FixedStepsOfTheExplicitIntegratorConvergeWithOrderFive) {
  const CartesianPendulum m;
  double error[2];
  for (int k = 0; k < 2; ++k) {
    State s = make_state(m);
    s.p << -1.0, 0.0;
    SolverOptions o = until(1.0, 1.0, 1e-6);
    o.method = "runge_kutta";
    o.fixed_step = k == 0 ? 0.02 : 0.01;
    const Recorded r = simulate(m, s, o);
    ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
    EXPECT_EQ(r.result.counts.steps, k == 0 ? 50 : 100);
    error[k] = (r.result.state.p - Eigen::Vector2d(.986291751132, -.165010853126)).norm();
  }
  // 2^5 = 32, less what the next order adds and the printed digits (1e-12) take.
  EXPECT_GT(error[0] / error[1], 20.0);
  EXPECT_LT(error[0] / error[1], 50.0);
}

TEST(Dynamics, DrivenCrankPaysForWhatTheDamperTakes) {
  PlanarMechanism m = slider_crank();
  m.constraints.push_back({PlanarPoint().slide(m.unit({0}), 1, 0), {1, 0}, 20.0, 0.3, "drive"});
  m.springs.push_back({PlanarPoint().slide(m.unit({2}), 1, 0), {1.0, 0.0}, 0.0, 0.2, 15.0});
  m.gravity = {0.0, -9.81};
  State s = make_state(m);
  s.p << 0.3, -0.1, 0.39;
  const Recorded r = simulate(m, s, until(2.0, 0.01, 1e-7));
  ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
  for (const State& row : r.rows) {
    const double a = 0.3 + 20.0 * row.t, b = -std::asin(0.1 * std::sin(a) / 0.3);
    EXPECT_NEAR(row.p(0), a, 1e-8);
    EXPECT_NEAR(row.p(2), 0.1 * std::cos(a) + 0.3 * std::cos(b), 1e-8);
  }
  // Over whole turns the drive pays the damper; here within what the parts store.
  EXPECT_GT(r.result.energy.work_in, 10.0);
  EXPECT_LT(std::abs(r.result.energy.error()), 1e-5 * r.result.energy.work_in);
}

TEST(Dynamics, ChainSwingsInItsModesAndConvergesWithTheTolerance) {
  SpringChain m(5);
  double before = 1.0;
  for (const double tolerance : {1e-4, 1e-7, 1e-10}) {
    State s = make_state(m);
    for (int i = 0; i < 5; ++i) s.p(i) = 0.01 * std::sin(2 * (i + 1) * M_PI / 6.0);
    const double T = 10.0 * 2.0 * M_PI / m.omega(2);
    const Eigen::VectorXd start = s.p;
    const Recorded r = simulate(m, s, until(T, T, tolerance));
    ASSERT_TRUE(r.result.complete) << r.result.stopped_because;
    const double error = (r.result.state.p - start).norm() / start.norm();
    EXPECT_LT(error, 0.1 * before) << tolerance;
    before = error;
  }
  EXPECT_LT(before, 1e-5);
}

// A crank driven at 10 revolutions a second; rows stand within the steps, at times of their own.
TEST(Dynamics, LoopsStayClosedWhateverTheTolerance) {
  PlanarMechanism m = slider_crank();
  m.constraints.push_back({PlanarPoint().slide(m.unit({0}), 1, 0), {1, 0}, 20.0 * M_PI, 0.3, "drive"});
  for (const char* method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    double loosest = 0.0;
    for (const double tolerance : {1e-3, 1e-4, 1e-6}) {
      State s = make_state(m);
      s.p << 0.3, -0.1, 0.39;
      SolverOptions o = until(2.0, 0.0137, tolerance);
      o.method = method;
      // As in the end of long runs, where nothing but the tolerance bounds the step.
      o.max_step = 2.0;
      const Recorded r = simulate(m, s, o);
      ASSERT_TRUE(r.result.complete) << method << ", " << tolerance << ": " << r.result.stopped_because;
      auto scratch = m.make_scratch();
      Eigen::VectorXd g(m.sizes().n_lambda);
      for (const State& row : r.rows) {
        m.position_constraints(row.t, row.p, *scratch, g);
        loosest = std::max(loosest, g.lpNorm<Eigen::Infinity>());
      }
      loosest = std::max(loosest, r.result.peak_position_drift);
    }
    // Rows of G move by at most 1 (rad or m of the drive): 1e-11 of that, some rows together.
    EXPECT_LT(loosest, 1e-10) << method;
  }
}

TEST(Dynamics, RunsStopCleanlyAndSayWhy) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << -1.0, 0.0;
  Eigen::VectorXd v_dot;
  assemble(m, s, v_dot);
  RunCallbacks callbacks;
  int steps = 0;
  callbacks.stop_wanted = [&] { return ++steps == 20; };
  RunResult r = run(m, s, v_dot, until(10.0, 0.01, 1e-6), callbacks);
  EXPECT_FALSE(r.complete);
  EXPECT_THAT(r.stopped_because, HasSubstr("interrupted at t = "));
  EXPECT_GT(r.state.t, 0.0);

  // A force that becomes infinite at t = 1 s.
  class Exploding : public SpringChain {
   public:
    using SpringChain::SpringChain;
    void momentum(const State& state, ConstVectorRef v_dot, Scratch& x, VectorRef r, VectorRef c,
                  VectorRef b) const override {
      SpringChain::momentum(state, v_dot, x, r, c, b);
      if (state.t > 1.0) r(1) = std::numeric_limits<double>::quiet_NaN();
    }
  } bomb(3);
  State s2 = make_state(bomb);
  s2.p << 0.01, 0, 0;
  assemble(bomb, s2, v_dot);
  r = run(bomb, s2, v_dot, until(2.0, 0.01, 1e-6));
  EXPECT_FALSE(r.complete);
  EXPECT_THAT(r.stopped_because, AllOf(HasSubstr("force on \"v1\" is not finite"), HasSubstr("at t = 1")));
  EXPECT_NEAR(r.state.t, 1.0, 1e-3);
}

}  // namespace
}  // namespace flexura::mbs::test
