// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "mbs/formulas/curve.hpp"
#include "tests/mbs/cases/text_case.hpp"

/// Single elements with exact answers: tables, drives on every level, curves as force laws, controls that
/// delay, switch or solve.
namespace flexura::mbs::cases {
namespace {

using ::testing::HasSubstr;

class Elements : public TextCase {};

TEST(Curve, SplineIsTwiceDifferentiableAndItsIntegralExact) {
  std::vector<double> x, y;
  for (int i = 0; i <= 12; ++i) x.push_back(0.1 * i * i), y.push_back(std::sin(x.back()));
  for (const auto outside : {Curve::Outside::hold, Curve::Outside::extend}) {
    const Curve curve(x, y, Curve::Interpolation::cubic, outside);
    for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(curve(x[i]), y[i], 1e-15);
    for (std::size_t i = 1; i + 1 < x.size(); ++i) {
      // One-sided values at distance 1e-9 differ by 1e-9 of the next derivative, of order one here.
      const Curve::Value below = curve.at(x[i] - 1e-9), above = curve.at(x[i] + 1e-9);
      EXPECT_NEAR(below.first, above.first, 1e-8);
      EXPECT_NEAR(below.second, above.second, 1e-7);
    }
    EXPECT_NEAR(curve.at(x.front()).second, 0.0, 1e-12);  // natural
    // Simpson's rule on 2,000 panels; the integrand's kinks beyond the ends cost 1e-6 at most.
    double sum = 0.0;
    const double a = -1.0, b = 16.0;
    const int n = 4000;
    for (int k = 0; k <= n; ++k)
      sum += (k == 0 || k == n ? 1.0 : k % 2 ? 4.0 : 2.0) * curve(a + (b - a) * k / n) * (b - a) / n / 3.0;
    EXPECT_NEAR(curve.integral(b) - curve.integral(a), sum, 1e-6);
  }
  const Curve line({0.0, 1.0, 3.0}, {1.0, 3.0, 7.0}, Curve::Interpolation::akima, Curve::Outside::extend);
  EXPECT_NEAR(line(2.2), 5.4, 1e-14);
  EXPECT_NEAR(line(-1.0), -1.0, 1e-14);
  EXPECT_NEAR(line.integral(3.0), 12.0, 1e-14);
  const Curve wave({0.0, 1.0, 2.0, 3.0, 4.0}, {0.0, 1.0, 0.0, -1.0, 0.0}, Curve::Interpolation::cubic,
                   Curve::Outside::repeat);
  EXPECT_NEAR(wave(9.3), wave(1.3), 1e-14);
  EXPECT_NEAR(wave.at(-1e-12).first, wave.at(1e-12).first, 1e-10);
  EXPECT_NEAR(wave.integral(8.5), wave.integral(0.5), 1e-14);
}

TEST_F(Elements, TableDrivesAJointWithItsDerivatives) {
  const PreparedMechanism p = prepared(wheel + R"toml(drive = "2*lift(t/2) + 0.1*t"
[table.lift]
x = [0, 0.2, 0.5, 0.7, 1]
y = [0, 0.1, 0.5, 0.4, 0.6]
)toml" + solver);
  const Series s = simulate(p, {"axle.angle", "axle.speed", "axle.drive_force"});
  const Curve lift({0, 0.2, 0.5, 0.7, 1}, {0, 0.1, 0.5, 0.4, 0.6}, Curve::Interpolation::cubic,
                   Curve::Outside::hold);
  for (std::size_t i = 0; i + 1 < s.t.size(); ++i) {
    const Curve::Value f = lift.at(0.5 * s.t[i]);
    // Interpolated by polynomials of order five at most across kinks of the third derivative.
    EXPECT_NEAR(s.values[i](0), 2.0 * f.value + 0.1 * s.t[i], 1e-6);
    EXPECT_NEAR(s.values[i](1), f.first + 0.1, 1e-5);
  }
}

TEST_F(Elements, DrivesOnSpeedAndAccelerationIntegrateToThePosition) {
  const PreparedMechanism speed = prepared(wheel + "drive_speed = \"3*cos(2*t)\"\nangle = 0.2\n" + solver);
  Series s = simulate(speed, {"axle.angle", "axle.speed", "axle.drive_force"});
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double t = s.t[i];
    // 1e-10 in each of some hundred steps.
    EXPECT_NEAR(s.values[i](0), 0.2 + 1.5 * std::sin(2 * t), 1e-7);
    EXPECT_NEAR(s.values[i](1), 3 * std::cos(2 * t), 1e-8);
    EXPECT_NEAR(s.values[i](2), -0.5 * 6 * std::sin(2 * t), 1e-5);  // inertia times acceleration
  }
  EXPECT_EQ(speed.mechanism->sizes().n_lambda, 1);
  const PreparedMechanism acceleration =
      prepared(wheel + "drive_acceleration = \"6*t + sqrt(t)\"\nspeed = 1\n" + solver);
  s = simulate(acceleration, {"axle.angle", "axle.speed"});
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double t = s.t[i];
    EXPECT_NEAR(s.values[i](1), 1 + 3 * t * t + 2.0 / 3.0 * std::pow(t, 1.5), 1e-7);
    EXPECT_NEAR(s.values[i](0), t + t * t * t + 4.0 / 15.0 * std::pow(t, 2.5), 1e-6);
  }
  EXPECT_THAT(refusal(wheel + "drive = \"t\"\ndrive_speed = \"1\"\n"),
              HasSubstr("the coordinate is driven twice"));
  EXPECT_THAT(refusal(wheel + "drive_speed = \"1\"\nspeed = 2\n"), HasSubstr("the speed is driven"));
}

TEST_F(Elements, CurvesOfSpringsAndBushingsKeepTheEnergy) {
  const PreparedMechanism p = prepared(R"toml(
gravity = [0, 0, -9.81]
[table.hard]
x = [-0.2, -0.1, 0, 0.1, 0.2]
y = [-300, -60, 0, 60, 300]
interpolation = "akima"
outside = "extend"
[table.valve]
x = [-1, 0, 1]
y = [-20, 0, 5]
interpolation = "linear"
outside = "extend"
[body.b]
mass = 2
inertia = [0.02, 0.03, 0.04]
velocity = [0.3, 0.1, 0]
[body.c]
mass = 1
inertia = [0.01, 0.01, 0.01]
position = [0, 0, -1]
[force.bush]
type = "bushing"
from = "ground"
to = "b"
rotational_stiffness = [5, 5, 5]
curve_x = "hard"
curve_y = "hard"
curve_z = "hard"
[force.hang]
type = "spring_damper"
from = "b"
to = "c"
free_length = 1
curve = "hard"
damping_curve = "valve"
)toml" + solver);
  const Series s = simulate(p, {"energy.total", "hang.force", "b.position_z"});
  EXPECT_GT(s.result.energy.dissipated, 0.01);
  // The energy book closes to the tolerance times the steps times the energy moved, some 10 J.
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-5);
}

TEST_F(Elements, DelayReturnsASineLater) {
  const PreparedMechanism p = prepared(wheel + R"toml(drive = "0"
[control.late]
type = "delay"
input = "sin(3*t)"
time = "0.4 s"
order = 7
)toml" + solver);
  const Series s = simulate(p, {"late"});
  // At omega T = 1.2 the approximation of order 7 is exact to 1e-9; its start-up from rest fades like exp(-10
  // t / T).
  for (std::size_t i = 0; i < s.t.size(); ++i)
    if (s.t[i] > 1.5) {
      EXPECT_NEAR(s.values[i](0), std::sin(3 * (s.t[i] - 0.4)), 1e-5) << s.t[i];
    }
}

TEST_F(Elements, RelaySwitchesAtTheExactTimes) {
  for (const char* method : {"ida", "runge_kutta"}) {
    const PreparedMechanism p = prepared(wheel + R"toml(drive = "0"
[control.level]
type = "state"
rate = "1 - 3*pump"
[control.pump]
type = "relay"
input = "level"
on_above = 0.5
off_below = 0.1
)toml" + solver + "method = \"" + method +
                                         "\"\n");
    const Series s = simulate(p, {"level", "pump"});
    // Rises with 1 from 0 to 0.5, falls with 2 to 0.1, rises with 1 to 0.5, ...
    double t = 0.5;
    ASSERT_GE(s.result.events.size(), 4u);
    for (std::size_t k = 0; k < s.result.events.size(); ++k) {
      EXPECT_NEAR(s.result.events[k].t, t, 1e-8);
      t += k % 2 == 0 ? 0.2 : 0.4;
    }
    EXPECT_NEAR(s.at(0.6)(0), 0.3, 1e-8);
    EXPECT_NEAR(s.at(0.6)(1), 1.0, 0.0);
  }
}

TEST_F(Elements, SampleHoldsItsValueFromTimeToTime) {
  // A double integrator under sampled feedback: q'' = -k q(t_n) from t_n to t_n + T, exactly.
  for (const char* method : {"ida", "runge_kutta"}) {
    const PreparedMechanism p = prepared(wheel + R"toml(angle = 1
[control.seen]
type = "sample"
input = "axle.angle"
period = "0.15 s"
[force.feedback]
type = "joint_force"
joint = "axle"
value = "-2*seen"
)toml" + solver + "method = \"" + method +
                                         "\"\n");
    const Series s = simulate(p, {"axle.angle", "seen"});
    double q = 1.0, v = 0.0, t_n = 0.0;
    for (std::size_t i = 0; i < s.t.size(); ++i) {
      while (s.t[i] > t_n + 0.15 - 1e-9) {
        const double a = -4.0 * q;
        q += 0.15 * v + 0.5 * 0.15 * 0.15 * a;
        v += 0.15 * a;
        t_n += 0.15;
      }
      const double t = s.t[i] - t_n;
      // At a sample's own time either value stands.
      if (t > 1e-6) {
        EXPECT_NEAR(s.values[i](1), q, 1e-8);
      }
      EXPECT_NEAR(s.values[i](0), q + v * t - 2.0 * q * t * t, 1e-8) << method << " " << s.t[i];
    }
    EXPECT_EQ(s.result.events.size(), 13u);
  }
}

TEST_F(Elements, AlgebraicLoopIsSolvedAlongTheMotion) {
  const PreparedMechanism p = prepared(wheel + R"toml(angle = 0.5
[control.grip]
type = "algebraic"
equation = "grip + 0.2*grip^3 + axle.angle"
[force.turn]
type = "joint_force"
joint = "axle"
value = "4*grip"
)toml" + solver);
  EXPECT_EQ(p.mechanism->sizes().n_alg, 1);
  EXPECT_EQ(p.mechanism->name_of_algebraic(0), "grip");
  const Series s = simulate(p, {"grip", "axle.angle", "axle.acceleration"});
  for (const Eigen::VectorXd& row : s.values) {
    // Interpolated between steps, to the tolerance.
    EXPECT_NEAR(row(0) + 0.2 * std::pow(row(0), 3) + row(1), 0.0, 1e-7);
    EXPECT_NEAR(0.5 * row(2), 4 * row(0), 1e-5);
  }
  EXPECT_THAT(refusal(wheel + "[control.a]\ntype = \"algebraic\"\nequation = \"axle.angle\"\n"),
              HasSubstr("does not depend on a"));
}

// A bead of 1 kg on a wire through points of a circle of radius 1 m that stands upright.
std::string wire(int n_points, const std::string& body_keys) {
  std::string points;
  for (int i = 0; i < n_points; ++i)
    points += fmt::format("{}[{:.17g}, 0, {:.17g}]", i ? ", " : "", std::sin(2 * M_PI * i / n_points),
                          -std::cos(2 * M_PI * i / n_points));
  return "[body.bead]\nmass = 1\ninertia = [1, 1, 1]\n" + body_keys +
         "\n[constraint.wire]\ntype = \"point_on_curve\"\nfrom = \"ground\"\nto = \"bead\"\nclosed = "
         "true\npoints = [" +
         points + "]\n";
}

TEST_F(Elements, BeadRunsRoundItsWireAndCountsTheRounds) {
  // From the top at 3 m/s, round after round.
  const PreparedMechanism p = prepared(wire(48, "position = [0, 0, 1]\nvelocity = [3, 0, 0]") + solver);
  EXPECT_EQ(p.mechanism->sizes().n_alg, 1);
  EXPECT_EQ(p.mechanism->name_of_algebraic(0), "wire.contact");
  const Series s = simulate(
      p, {"bead.position_x", "bead.position_z", "bead.velocity_x", "bead.velocity_z", "wire.contact"});
  const double round = 48 * 2 * std::sin(M_PI / 48);
  for (const Eigen::VectorXd& row : s.values) {
    // A wire without friction keeps the energy whatever its shape; 1e-10 in each of some thousand steps.
    EXPECT_NEAR(0.5 * (row(2) * row(2) + row(3) * row(3)) + 9.81 * row(1), 4.5 + 9.81, 1e-6);
    // The spline leaves the circle by (2 pi / 48)^4 / 384 = 8e-7.
    EXPECT_NEAR(std::hypot(row(0), row(1)), 1.0, 2e-6);
    EXPECT_NEAR(std::remainder(row(4) / round * 2 * M_PI - std::atan2(row(0), -row(1)), 2 * M_PI), 0.0, 1e-4);
  }
  EXPECT_GT(std::abs(s.values.back()(4) - s.values.front()(4)), round);
  EXPECT_LT(s.result.peak_position_drift, 1e-9);
}

TEST_F(Elements, BeadSwingsAsThePendulumOfItsWire) {
  // Small swings about the lowest point: the period of a pendulum of 1 m, 2 pi sqrt(1 / g) (1 + phi^2 / 16).
  const double phi = 0.02;
  const PreparedMechanism p = prepared(
      wire(96, fmt::format("position = [{:.17g}, 0, {:.17g}]", std::sin(phi), -std::cos(phi))) + solver);
  const double period = 2 * M_PI / std::sqrt(9.81) * (1 + phi * phi / 16);
  const Series s = simulate(p, {"bead.position_x"});
  for (std::size_t i = 0; i < s.t.size(); ++i)
    // The spline's curvature is wrong by some (2 pi / 96)^2 / 12 = 4e-4, the phase after a period by as much,
    // and sin(phi) differs from phi by 1e-6.
    EXPECT_NEAR(s.values[i](0), phi * std::cos(2 * M_PI * s.t[i] / period), phi * 3e-3);
}

TEST_F(Elements, SphereRestsOnACurveAsOnTheCylinderThatItDraws) {
  std::string points;
  for (int i = 0; i < 60; ++i)
    points += fmt::format("{}[{:.17g}, {:.17g}, 0]", i ? ", " : "", 0.5 * std::sin(2 * M_PI * i / 60),
                          0.5 * std::cos(2 * M_PI * i / 60));  // clockwise: its left side is outside
  const auto text = [&](const std::string& surface) {
    return "gravity = [0, -9.81, 0]\n[body.ball]\nmass = 1\ninertia = [1, 1, 1]\nposition = [0.1, 0.8, 0]\n"
           "[force.touch]\ntype = \"contact\"\nfrom = \"ground\"\nto = \"ball\"\nradius = 0.1\nstiffness = "
           "1e4\n"
           "restitution = 0.6\n" +
           surface + solver;
  };
  const PreparedMechanism on_curve =
      prepared(text("surface = \"curve\"\nclosed = true\npoints = [" + points + "]\n"));
  const PreparedMechanism on_cylinder = prepared(text("surface = \"cylinder\"\nsurface_radius = 0.5\n"));
  EXPECT_NEAR(now(on_curve, {"touch.gap"})(0), std::hypot(0.1, 0.8) - 0.6, 1e-7);
  const Series a = simulate(on_curve, {"ball.position_x", "ball.position_y", "touch.gap"});
  const Series b = simulate(on_cylinder, {"ball.position_x", "ball.position_y", "touch.gap"});
  // The spline leaves the circle by (2 pi / 60)^4 / 384 / 2 = 2e-7 and its normal by 1e-5; the ball bounces
  // off.
  for (std::size_t i = 0; i < a.t.size(); ++i) EXPECT_LT((a.values[i] - b.values[i]).norm(), 2e-4) << a.t[i];
  ASSERT_GE(a.result.events.size(), 2u);
}

TEST_F(Elements, RefusesWhatCannotBe) {
  EXPECT_THAT(refusal(wire(2, "")), HasSubstr("has 2 points; a closed curve needs 3"));
  EXPECT_THAT(refusal(wheel + "[table.a]\nx = [0, 1, 1]\ny = [0, 1, 2]\n"), HasSubstr("x must rise"));
  EXPECT_THAT(refusal(wheel + "[table.a]\nx = [0, 1]\ny = [0]\n"), HasSubstr("has 2 x and 1 y"));
  EXPECT_THAT(
      refusal(wheel +
              "[table.lift]\nx = [0, 1]\ny = [0, 1]\n[force.f]\ntype = \"joint_spring_damper\"\njoint = "
              "\"axle\"\ncurve = \"lft\"\n"),
      HasSubstr("there is no table \"lft\", did you mean \"lift\"?"));
  EXPECT_THAT(refusal(wheel + "[force.f]\ntype = \"bump_stop\"\njoint = \"axle\"\nstiffness = 1\n"),
              HasSubstr("has neither lower nor upper"));
  EXPECT_THAT(
      refusal(wheel +
              "[force.f]\ntype = \"contact\"\nfrom = \"ground\"\nto = \"wheel\"\nradius = 1\nstiffness "
              "= 1\nsurface = \"sphere\"\n"),
      HasSubstr("surface_radius is missing"));
  EXPECT_THAT(refusal(wheel + "[force.f]\ntype = \"stick_slip\"\njoint = \"axle\"\ncoulomb = 2\nstatic = 1\n"
                              "stick_stiffness = 1\n"),
              HasSubstr("is below coulomb"));
  // A loop of three hinges and a fourth: its last joint's angle follows from the others'.
  EXPECT_THAT(refusal(wheel + "angle = 0.1\n[joint.again]\ntype = \"revolute\"\nfrom = \"ground\"\nto = "
                              "\"wheel\"\nangle = 0.3\n"),
              HasSubstr("closes a loop"));
}

}  // namespace
}  // namespace flexura::mbs::cases
