// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "mbs/solver/linear/linearise.hpp"
#include "tests/mbs/cases/text_case.hpp"

/// Drives whose value is a signal of a control, against closed solutions and against the same motion by time.
namespace flexura::mbs::cases {
namespace {

using ::testing::HasSubstr;

const std::string cart = R"toml(
gravity = [0, 0, 0]
[ground.marker.g]
axis = [0, 0, 1]
[body.cart]
mass = 2
inertia = [1, 1, 1]
[body.cart.marker.s]
axis = [0, 0, 1]
[joint.rail]
type = "prismatic"
from = "ground.g"
to = "cart.s"
)toml";

// A pendulum of 0.5 m with all its mass at the tip hangs from the cart.
const std::string pendulum = R"toml(
gravity = [0, -9.81, 0]
[ground.marker.g]
axis = [1, 0, 0]
[body.cart]
mass = 2
inertia = [1, 1, 1]
[body.cart.marker.s]
axis = [1, 0, 0]
[body.cart.marker.hook]
[body.bob]
mass = 1
center = [0, -0.5, 0]
inertia = [1e-12, 1e-12, 1e-12]
[body.bob.marker.hook]
[joint.rail]
type = "prismatic"
from = "ground.g"
to = "cart.s"
DRIVE
[joint.hook]
type = "revolute"
from = "cart.hook"
to = "bob.hook"
angle = ANGLE
)toml";

std::string hanging(const std::string& drive, double angle) {
  std::string text = pendulum;
  text.replace(text.find("DRIVE"), 5, drive);
  text.replace(text.find("ANGLE"), 5, fmt::format("{}", angle));
  return text;
}

struct Method {
  std::string name;
  double error;  ///< of positions and speeds, at a tolerance of 1e-9
  std::string solver(double end, double step = 0.1) const {
    return fmt::format("[solver]\nend_time = {}\noutput_step = {}\nmethod = \"{}\"\ntolerance = 1e-9\n", end,
                       step, name);
  }
};
// Of variable steps some hundred times the tolerance is left over the run; of order two at most ten times more.
const Method methods[] = {{"ida", 2e-7}, {"radau", 2e-7}, {"runge_kutta", 2e-7}, {"generalised_alpha", 2e-6}};

class FollowingDrives : public TextCase, public ::testing::WithParamInterface<Method> {};

TEST_P(FollowingDrives, PositionOfTheSecondOrderLagOfAStep) {
  // Y = U / (1 + s/w)^2 of a unit step: y = 1 - (1 + w t) exp(-w t), y' = w^2 t exp(-w t).
  const PreparedMechanism p = prepared(cart +
                                       "drive = \"0.3*servo\"\n[control.servo]\ntype = "
                                       "\"transfer_function\"\ninput = \"1\"\nnumerator = [25]\n"
                                       "denominator = [25, 10, 1]\n" +
                                       GetParam().solver(2));
  const Series s =
      simulate(p, {"rail.position", "rail.speed", "rail.acceleration", "rail.drive_force", "energy.balance"});
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double w = 5, t = s.t[i], e = std::exp(-w * t);
    EXPECT_NEAR(s.values[i](0), 0.3 * (1 - (1 + w * t) * e), GetParam().error) << t;
    EXPECT_NEAR(s.values[i](1), 0.3 * w * w * t * e, w * GetParam().error) << t;
    EXPECT_NEAR(s.values[i](2), 0.3 * w * w * (1 - w * t) * e, w * w * GetParam().error) << t;
    EXPECT_NEAR(s.values[i](3), 2 * s.values[i](2), 1e-11);
  }
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-6 * s.result.energy.peak);
}

TEST_P(FollowingDrives, SpeedAndAccelerationOfAState) {
  // x'' = -9 x from 0.2: x = 0.2 cos 3t, as a speed and, of its own state, as an acceleration.
  const std::string oscillator =
      "[control.x]\ntype = \"state\"\nrate = \"w\"\nstart = 0.2\n[control.w]\ntype = \"state\"\nrate = "
      "\"-9*x\"\n";
  const PreparedMechanism by_speed =
      prepared(cart + "drive_speed = \"x\"\n" + oscillator + GetParam().solver(2));
  const PreparedMechanism by_acceleration =
      prepared(cart + "speed = 0.1\ndrive_acceleration = \"x\"\n" + oscillator + GetParam().solver(2));
  const Series v = simulate(by_speed, {"rail.position", "rail.speed", "rail.acceleration"}),
               a = simulate(by_acceleration, {"rail.position", "rail.speed", "rail.acceleration"});
  for (std::size_t i = 0; i < v.t.size(); ++i) {
    const double t = v.t[i], integral = 0.2 / 3 * std::sin(3 * t);
    EXPECT_NEAR(v.values[i](0), integral, GetParam().error);
    EXPECT_NEAR(v.values[i](1), 0.2 * std::cos(3 * t), 3 * GetParam().error);
    EXPECT_NEAR(v.values[i](2), -0.6 * std::sin(3 * t), 9 * GetParam().error);
    EXPECT_NEAR(a.values[i](0), 0.1 * t + 0.2 / 9 * (1 - std::cos(3 * t)), GetParam().error);
    EXPECT_NEAR(a.values[i](1), 0.1 + integral, GetParam().error);
    EXPECT_NEAR(a.values[i](2), 0.2 * std::cos(3 * t), 9 * GetParam().error);
  }
}

// Where a drive sets off with a speed the rest starts as the file has it, at rest on what is driven, whoever gives the speed:
// a control's was a blow to the pendulum, of 0.55 m/s over its half metre.
TEST_P(FollowingDrives, SetOffWithoutABlowToTheRest) {
  const std::string law = "[control.law]\ntype = \"state\"\nrate = \"-2*law\"\nstart = 1\n";
  for (const std::string& drive :
       {std::string("drive_speed = \"exp(-2*t)\""), std::string("drive_speed = \"law\""),
        std::string("drive = \"(1 - law)/2\"")}) {
    SCOPED_TRACE(drive);
    const PreparedMechanism p = prepared(hanging(drive, 0.3) + law + GetParam().solver(1));
    EXPECT_NEAR(p.state.v(0), 1.0, 1e-12);
    EXPECT_NEAR(p.state.v(1), 0.0, 1e-12);
  }
  // So it is where the run begins later; the speed given is kept.
  const PreparedMechanism later =
      prepared(hanging("drive = \"sin(t)\"", 0.3) + GetParam().solver(2) + "start_time = 1\n");
  EXPECT_NEAR(later.state.v(0), std::cos(1.0), 1e-12);
  EXPECT_NEAR(later.state.v(1), 0.0, 1e-12);
}

TEST_P(FollowingDrives, AFormulaOfSignalsIsDifferentiatedTwice) {
  // q = x y + sin(t) / 10 with x = exp(-t), y = t^2 / 2.
  const PreparedMechanism p =
      prepared(cart +
               "drive = \"both + sin(t)/10\"\n[control.x]\ntype = \"state\"\nrate = \"-x\"\nstart = 1\n"
               "[control.y]\ntype = \"state\"\nrate = \"z\"\n[control.z]\ntype = \"state\"\nrate = \"1\"\n"
               "[measure.both]\ntype = \"expression\"\nvalue = \"x*y\"\n" +
               GetParam().solver(3));
  const Series s = simulate(p, {"rail.position", "rail.speed", "rail.acceleration"});
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double t = s.t[i], e = std::exp(-t);
    EXPECT_NEAR(s.values[i](0), e * t * t / 2 + std::sin(t) / 10, GetParam().error);
    EXPECT_NEAR(s.values[i](1), e * (t - t * t / 2) + std::cos(t) / 10, GetParam().error);
    EXPECT_NEAR(s.values[i](2), e * (1 - 2 * t + t * t / 2) - std::sin(t) / 10, 4 * GetParam().error);
  }
}

TEST_P(FollowingDrives, AClosedLoopIsThatOfTheKinematicCart) {
  // The cart's acceleration is fed back from the hanging pendulum, x'' = 4 phi + phi' - 2 x - 3 x', through states whose
  // position the drive follows.  The same equations by hand, integrated here by small steps of order 4.
  const PreparedMechanism p =
      prepared(hanging("drive = \"x\"", 0.4) +
               "[control.x]\ntype = \"state\"\nrate = \"w\"\n[control.w]\ntype = \"state\"\n"
               "rate = \"4*hook.angle + hook.speed - 2*x - 3*w\"\n" +
               GetParam().solver(3));
  const Series s = simulate(p, {"rail.position", "hook.angle", "hook.speed"});
  Eigen::Vector4d y(0.4, 0, 0, 0);  // phi, phi', x, x'
  const auto f = [](const Eigen::Vector4d& z) {
    const double a = 4 * z(0) + z(1) - 2 * z(2) - 3 * z(3);
    return Eigen::Vector4d(z(1), -(9.81 * std::sin(z(0)) + a * std::cos(z(0))) / 0.5, z(3), a);
  };
  const int per_row = 200;
  const double h = 0.1 / per_row;  // h^5 of a fifth derivative of some 1e4, over 6000 steps: below 1e-11
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    EXPECT_NEAR(s.values[i](0), y(2), 4 * GetParam().error) << s.t[i];
    EXPECT_NEAR(s.values[i](1), y(0), 4 * GetParam().error) << s.t[i];
    EXPECT_NEAR(s.values[i](2), y(1), 20 * GetParam().error) << s.t[i];
    for (int k = 0; k < per_row; ++k) {
      const Eigen::Vector4d k1 = f(y), k2 = f(y + 0.5 * h * k1), k3 = f(y + 0.5 * h * k2), k4 = f(y + h * k3);
      y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
  }
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-6);
}

TEST_P(FollowingDrives, ASampledSpeedJumpsAndARateThatSwitchesTurns) {
  // 0, 1, 1 ... m/s from sample to sample; then a triangle wave, whose speed changes where it meets +-0.1.
  const PreparedMechanism sampled = prepared(
      cart + "drive_speed = \"s\"\n[control.s]\ntype = \"sample\"\ninput = \"floor(2*t)\"\nperiod = 0.25\n" +
      GetParam().solver(2, 0.25));
  const Series v = simulate(sampled, {"rail.position"});
  EXPECT_NEAR(v.values.back()(0), 0.5 * (1 + 2 + 3), 1e-9);
  const PreparedMechanism wave = prepared(cart +
                                          "drive = \"x\"\n[control.r]\ntype = \"relay\"\ninput = "
                                          "\"x\"\non_above = 0.1\noff_below = -0.1\non = -1\n"
                                          "off = 1\n[control.x]\ntype = \"state\"\nrate = \"r\"\n" +
                                          GetParam().solver(1, 0.05));
  const Series x = simulate(wave, {"rail.position"});
  for (std::size_t i = 0; i < x.t.size(); ++i)
    EXPECT_NEAR(x.values[i](0), 0.1 / (M_PI / 2) * std::asin(std::sin(M_PI / 2 * x.t[i] / 0.1)), 1e-8)
        << x.t[i];
}

INSTANTIATE_TEST_SUITE_P(By, FollowingDrives, ::testing::ValuesIn(methods),
                         [](const auto& info) { return info.param.name; });

class FollowingDriveFiles : public TextCase {};

TEST_F(FollowingDriveFiles, EigenvaluesAreThoseOfTheKinematicCart) {
  // phi'' = -(g phi + a) / l, a = 4 phi + phi' - 2 x - 3 x' at rest.
  const PreparedMechanism p =
      prepared(hanging("drive = \"x\"", 0.0) +
               "[control.x]\ntype = \"state\"\nrate = \"w\"\n[control.w]\ntype = \"state\"\n"
               "rate = \"4*hook.angle + hook.speed - 2*x - 3*w\"\n" +
               solver);
  const LinearSystem system = linearise(*p.mechanism, p.state);
  Eigen::Matrix4d A;  // phi, phi', x, x'
  A << 0, 1, 0, 0, -(9.81 + 4) / 0.5, -1 / 0.5, 2 / 0.5, 3 / 0.5, 0, 0, 0, 1, 4, 1, -2, -3;
  ASSERT_EQ(system.A.rows(), 4);
  // The characteristic polynomials at a point: the same where all eigenvalues are.
  for (const double at : {1.0, -2.0, 3.5}) {
    const Eigen::Matrix4d I = Eigen::Matrix4d::Identity();
    EXPECT_NEAR((system.A - at * I).determinant() / (A - at * I).determinant(), 1.0, 1e-6) << at;
  }
}

TEST_F(FollowingDriveFiles, GearsAndTrolleysFollowToo) {
  const PreparedMechanism p = prepared(wheel + R"toml([constraint.c]
type = "coupler"
joints = ["axle"]
factors = [2]
offset = "y"
[control.y]
type = "transfer_function"
input = "1"
numerator = [4]
denominator = [4, 4, 1]
)toml" + solver);
  const Series s = simulate(p, {"axle.angle"});
  for (std::size_t i = 0; i < s.t.size(); ++i)
    EXPECT_NEAR(2 * s.values[i](0), 1 - (1 + 2 * s.t[i]) * std::exp(-2 * s.t[i]), 1e-8);
}

TEST_F(FollowingDriveFiles, SayWhatTheyCannotFollow) {
  const auto driven = [&](const std::string& drive, const std::string& control) {
    return refusal(hanging(drive, 0.1) + control + solver);
  };
  const std::string relay = "[control.r]\ntype = \"relay\"\ninput = \"hook.angle\"\n";
  EXPECT_THAT(driven("drive = \"r\"", relay),
              HasSubstr("\"r\" jumps where it switches, and no position can"));
  EXPECT_THAT(driven("drive = \"y > 0 ? 1 : 0\"", "[control.y]\ntype = \"state\"\nrate = \"1\"\n"),
              HasSubstr("jumps with the motion, and no position can"));
  EXPECT_THAT(driven("drive = \"hook.angle\"", ""), HasSubstr("by a constraint (type = \"expression\")"));
  EXPECT_THAT(driven("drive = \"k\"", "[control.k]\ntype = \"pid\"\nerror = \"hook.angle\"\n"),
              HasSubstr("a pid that passes on what it reads"));
  EXPECT_THAT(
      driven("drive = \"y\"", "[control.y]\ntype = \"state\"\nrate = \"hook.speed\"\n"),
      HasSubstr(
          "it reads \"hook.speed\", a speed, whose rate is an acceleration; put a control of type filter"));
  EXPECT_THAT(driven("drive_speed = \"hook.speed\"", ""),
              HasSubstr("a speed, whose rate is an acceleration"));
  EXPECT_THAT(driven("drive = \"y\"", "[control.y]\ntype = \"algebraic\"\nequation = \"y - hook.angle\"\n"),
              HasSubstr("an algebraic state that depends on \"hook.angle\", a coordinate"));
  EXPECT_THAT(driven("drive = \"y\"",
                     "[control.y]\ntype = \"algebraic\"\nequation = \"y - sign(z)\"\n[control.z]\ntype = "
                     "\"state\"\nrate = \"1\"\n"),
              HasSubstr("\"y\" jumps where it switches"));
  EXPECT_THAT(driven("drive = \"y\"",
                     "[control.y]\ntype = \"algebraic\"\nequation = \"y - 2*z + t\"\n[control.z]\ntype = "
                     "\"algebraic\"\nequation = \"z - y\"\n"),
              HasSubstr("\"y\" is an algebraic state that depends on itself through others"));
  EXPECT_THAT(driven("drive = \"z\"", "[control.y]\ntype = \"state\"\nrate = \"1\"\n"),
              HasSubstr("\"z\" is not known"));
}

}  // namespace
}  // namespace flexura::mbs::cases
