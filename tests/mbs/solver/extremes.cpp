// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "mbs/solver/algebra/accelerations.hpp"
#include "tests/mbs/solver/method_runs.hpp"
#include "tests/mbs/solver/planar.hpp"

/// Numerical stability at the extremes, as a table: `tests/run extremes` gathers it into out/extremes.html.
/// IDA unless said otherwise; each bound is derived where it stands.
namespace flexura::mbs::test {
namespace {

void report(const std::string& extreme, const std::string& value, const std::string& measured, double result,
            double bound) {
  char line[400];
  std::snprintf(line, sizeof line, "| %s | %s | %s | %.1e | %.0e |\n", extreme.c_str(), value.c_str(),
                measured.c_str(), result, bound);
  std::printf("%s", line);
  EXPECT_LT(result, bound) << line;
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", x);
  return text;
}

// Two rods in a row on a hinge, lengths and masses given; q = angles.
PlanarMechanism double_pendulum(double mass_1, double mass_2, double length, double g) {
  PlanarMechanism m(2);
  m.gravity = {0.0, -g};
  const auto a = m.unit({0}), b = m.unit({1});
  m.bodies = {
      {mass_1, mass_1 * length * length / 12, a, PlanarPoint().turn(a, length / 2, 0)},
      {mass_2, mass_2 * length * length / 12, b, PlanarPoint().turn(a, length, 0).turn(b, length / 2, 0)}};
  return m;
}

TEST(Extremes, MassRatios) {
  for (const double ratio : {1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9}) {
    const PlanarMechanism m = double_pendulum(1.0, ratio, 1.0, 9.81);
    State s = make_state(m);
    s.p << -0.3, 0.4;
    const RunResult r = simulate(m, s, until(5.0, 1e-9));
    // 1e-9 a step in each of about 3000 steps.
    report("mass ratio of two bodies", number(ratio), "energy error / energy moved, 5 s",
           r.energy.relative_error(), 1e-5);
  }
}

TEST(Extremes, MassRatiosInAClosedLoop) {
  for (const double ratio : {1e-9, 1e9}) {
    PlanarMechanism m = slider_crank();
    m.gravity = {0.0, -9.81};
    m.bodies[2].mass *= ratio;
    State s = make_state(m);
    s.p << 0.8, -0.2, 0.35;
    // A slider of 1e9 kg that moves would tear the crank round at its dead point.
    s.v << (ratio > 1.0 ? 0.1 : 10.0), 0.0, 0.0;
    SolverOptions o = until(1.0, 1e-9);
    const RunResult r = simulate(m, s, o);
    report("mass of the slider of a slider-crank", number(ratio), "energy error / energy moved, 1 s",
           r.energy.relative_error(), 1e-5);
    report("mass of the slider of a slider-crank", number(ratio), "largest constraint residual [m]",
           r.peak_position_drift, 1e-9);
  }
}

// Masses of 1 kg on springs of 1 N/m (to ground) and k (between them): a slow mode at exactly 1 / sqrt(2).
class StiffPair : public SimpleEquations {
 public:
  double stiffness = 1e12;
  Sizes sizes() const override { return {.n_p = 2, .n_v = 2}; }
  void momentum(const State& s, ConstVectorRef v_dot, Scratch&, VectorRef r, VectorRef,
                VectorRef) const override {
    const double f = stiffness * (s.p(1) - s.p(0));
    r(0) = v_dot(0) + s.p(0) - f;
    r(1) = v_dot(1) + f;
  }
  void mass_matrix(ConstVectorRef, Scratch&, MatrixRef M) const override { M.setIdentity(); }
};

TEST(Extremes, StiffnessRatios) {
  for (const double stiffness : {1e6, 1e9, 1e12}) {
    StiffPair m;
    m.stiffness = stiffness;
    State s = make_state(m);
    s.p << 1.0, 1.0;
    // Ten periods of the slow mode; the spring's own vibration (up to 1e6 rad/s, excited by its preload of
    // 0.5 N) is damped out by BDF of order 2.
    const double period = 2.0 * M_PI * std::sqrt(2.0);
    for (const char* method : {"ida", "generalised_alpha"}) {
      SolverOptions o = until(10 * period, 1e-6);
      o.method = method;
      o.max_order = 2;
      o.rho_inf = 0.5;
      const RunResult r = simulate(m, s, o);
      // Order 2 at 1e-6: about 1e-4 in the phase of each period.
      report(std::string("stiffness ratio, ") + method, number(stiffness), "error after ten slow periods",
             (r.state.p - Eigen::Vector2d(1.0, 1.0)).norm(), 2e-2);
    }
  }
}

TEST(Extremes, DeadPointsOfTheParallelogram) {
  const PlanarMechanism m = windows(1);
  State s = make_state(m);
  s.p << M_PI / 2, M_PI / 2, 0.0;
  s.v << -8.0, -8.0, 0.0;  // fast enough to turn over, through both dead points, again and again
  // Each dead point is a fork to the antiparallelogram: sooner or later a run ends on one, which is then a
  // clean stop (this one at 6.3 s).
  const RunResult r = simulate(m, s, until(5.0, 1e-8));
  report("four-bar through its dead points", number(std::floor(std::abs(r.state.p(0)) / M_PI)) + " passes",
         "energy error / energy moved", r.energy.relative_error(), 1e-5);
}

// Rows of a file that follow from others are left out before a run (tests/mbs/app/extremes.cpp displaces them, too); here they are
// in the equations.
TEST(Extremes, RedundantConstraints) {
  for (const char* const method : {"ida", "radau", "generalised_alpha", "runge_kutta"}) {
    PlanarMechanism m = windows(2);
    const auto single = m.constraints;
    m.constraints.insert(m.constraints.end(), single.begin(), single.end());
    State s = make_state(m);
    s.p << M_PI / 2, M_PI / 2, M_PI / 2, 0.0, 0.0;
    s.v << -1.0, -1.0, -1.0, 0.0, 0.0;
    Eigen::VectorXd v_dot;
    assemble(m, s, v_dot);
    const RunResult r = run(m, s, v_dot, until(2.0, 1e-6, method));
    EXPECT_TRUE(r.complete) << r.stopped_because;
    // IFToMM A02 at t = 2 s; 1e-6 a step through two singular positions.
    report(std::string("every constraint twice, ") + method, "2 s", "error of the position",
           std::abs(std::cos(r.state.p(0)) - .057815795768), 1e-3);
  }
}

TEST(Extremes, AMillionRevolutions) {
  PlanarMechanism wheel(1);
  wheel.bodies = {{1.0, 1.0, wheel.unit({0}), PlanarPoint().turn(wheel.unit({0}), 0.1, 0.0)}};
  State s = make_state(wheel);
  s.v << 2.0 * M_PI * 1e3;
  const RunResult r = simulate(wheel, s, until(1000.0, 1e-8));
  // The angle is linear in time: round-off of 2 pi 1e6 and of the sum over the steps.
  report("revolutions", "1e6", "error of the angle, relative", std::abs(r.state.p(0) / (2e6 * M_PI) - 1.0),
         1e-12);
}

TEST(Extremes, AThousandRevolutionsOfALoop) {
  PlanarMechanism m = slider_crank();
  m.constraints.push_back({PlanarPoint().slide(m.unit({0}), 1, 0), {1, 0}, 2.0 * M_PI * 100.0, 0.3, "drive"});
  State s = make_state(m);
  s.p << 0.3, -0.1, 0.39;
  for (const char* method : {"ida", "generalised_alpha", "radau", "runge_kutta"})
    for (const double tolerance : {1e-4, 1e-6}) {
      SolverOptions o = until(10.0, tolerance, method);
      o.output_step = 3.7e-3;  // rows stand within steps, anywhere in a turn
      const RunResult r = simulate(m, s, o);
      // What a run gives away is closed to round-off (1e-11 of its lengths), whatever the tolerance.
      report(std::string("1000 revolutions of a slider-crank, ") + method, "tolerance " + number(tolerance),
             "largest constraint residual [m]", r.peak_position_drift, 1e-9);
    }
}

TEST(Extremes, TenThousandSeconds) {
  const CartesianPendulum m;
  State s = make_state(m);
  s.p << std::sin(0.5), -std::cos(0.5);
  SolverOptions o = until(10000.0, 1e-8);
  const RunResult r = simulate(m, s, o);
  // 1e-8 a step, some 1e6 steps, and BDF loses what it loses to one side.
  report("length of a run (pendulum, 5000 swings)", "1e4 s", "energy error / energy moved",
         r.energy.relative_error(), 1e-1);
  // Closed to round-off at every step.
  report("length of a run (pendulum, 5000 swings)", "1e4 s", "largest constraint residual [m]",
         r.peak_position_drift, 1e-9);
}

TEST(Extremes, StepsAtAndPastTheStabilityLimit) {
  SpringChain m(1);
  m.stiffness = 0.35;  // one mass of 0.7 kg between two springs: omega = 1
  State s = make_state(m);
  s.p << 1.0;
  // Dormand-Prince on the imaginary axis: |R(i h)| < 1 up to h = 0.998..., then it grows.
  const auto amplitude = [&](double h, const char* method) {
    SolverOptions o = until(1000.0 * h, 1e-6);
    o.method = method;
    o.fixed_step = h;
    Eigen::VectorXd v_dot;
    State start = s;
    assemble(m, start, v_dot);
    const RunResult r = run(m, start, v_dot, o);
    EXPECT_TRUE(r.complete) << r.stopped_because;
    return std::hypot(r.state.p(0), r.state.v(0));
  };
  report("fixed step, runge_kutta, omega h", "0.9", "growth of the amplitude in 1000 steps",
         amplitude(0.9, "runge_kutta"), 1.0);
  report("fixed step, generalised_alpha, omega h", "1000", "amplitude left after 1000 steps",
         amplitude(1000.0, "generalised_alpha"), 1.0);
  // Past the limit the run must end cleanly with a growing, still finite state, or stop and say so.
  SolverOptions o = until(5000.0, 1e-6);
  o.method = "runge_kutta";
  o.fixed_step = 5.0;
  Eigen::VectorXd v_dot;
  State start = s;
  assemble(m, start, v_dot);
  const RunResult r = run(m, start, v_dot, o);
  EXPECT_FALSE(r.complete);
  EXPECT_TRUE(r.state.p.allFinite());
  report("fixed step, runge_kutta, omega h", "5", "stopped cleanly before t / end time", r.state.t / 5000.0,
         1.0);
}

TEST(Extremes, SizesOfBodies) {
  // With lengths times L and times as sqrt(L) the motion is the same.
  const auto angle = [](double length) {
    const PlanarMechanism m = double_pendulum(std::pow(length, 3), std::pow(length, 3), length, 9.81);
    State s = make_state(m);
    s.p << -0.3, 0.4;
    SolverOptions o = until(3.0 * std::sqrt(length), 1e-9);
    // Rates scale with 1 / sqrt(L): so does their absolute error.
    return simulate(m, s, o).state.p(0);
  };
  const double reference = angle(1.0);
  for (const double length : {1e-6, 1e-3, 1e3, 1e6})
    report("length of bodies [m]", number(length), "difference to the run with 1 m",
           std::abs(angle(length) - reference), 1e-5);
}

}  // namespace
}  // namespace flexura::mbs::test
