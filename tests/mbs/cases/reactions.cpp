// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/mbs/cases/text_case.hpp"

/// Formulas that read what constraints, joints, drives and forces exert, and constraints that are formulas: against closed
/// solutions, by every method.
namespace flexura::mbs::cases {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class Reactions : public TextCase, public ::testing::WithParamInterface<std::string> {
 protected:
  Series run(const std::string& text, double end, const std::vector<std::string>& names) const {
    return simulate(prepared(text + fmt::format("[solver]\nend_time = {}\noutput_step = {}\nmethod = \"{}\"\n"
                                                "tolerance = 1e-9\n",
                                                end, end / 10, GetParam())),
                    names);
  }
};

// A body of 2 kg that slides in the xz plane without turning.
const std::string slider = R"toml(
[body.a]
mass = 0
[body.a.marker.m]
axis = [0, 0, 1]
[body.b]
mass = 2
inertia = [1, 1, 1]
[body.b.marker.m]
axis = [0, 0, 1]
[ground.marker.x]
axis = [1, 0, 0]
[body.a.marker.x]
axis = [1, 0, 0]
[joint.x]
type = "prismatic"
from = "ground.x"
to = "a.x"
%X%
[joint.z]
type = "prismatic"
from = "a.m"
to = "b.m"
%Z%
)toml";

std::string with(std::string text, const std::string& x, const std::string& z) {
  text.replace(text.find("%X%"), 3, x);
  return text.replace(text.find("%Z%"), 3, z);
}

// Down a slope of 30 degrees that a formula gives: g = z + x tan 30 deg, whose gradient has the length 1 / cos 30 deg, so
// that the normal force is m g cos 30 deg and the multiplier m g cos^2 30 deg.
TEST_P(Reactions, FrictionOnASlopeByAFormulaIsCoulombs) {
  const std::string text = "gravity = [0, 0, -9.81]\n" +
                           with(slider, "speed = 1", "speed = -0.5773502691896257") +
                           R"toml(
[constraint.slope]
type = "expression"
value = "z.position + x.position*tan(pi/6)"
unit = "m"
[measure.push]
type = "reaction"
quantity = "slope.force"
[measure.friction]
type = "expression"
value = "0.2*abs(push)/cos(pi/6)"
[force.friction]
type = "force"
marker = "b"
x = "-friction*cos(pi/6)"
z = "friction*sin(pi/6)"
)toml";
  const Series s = run(text, 1, {"x.position", "push", "slope.force", "friction"});
  const double c = std::sqrt(0.75), N = 2 * 9.81 * c, a = 9.81 * (0.5 - 0.2 * c) * c;  // a: of x
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double t = s.t[i];
    EXPECT_NEAR(s.values[i](0), t + 0.5 * a * t * t, 1e-7) << t;
    EXPECT_NEAR(s.values[i](1), N * c, 1e-7) << t;
    EXPECT_NEAR(s.values[i](2), N * c, 1e-7) << t;
    EXPECT_NEAR(s.values[i](3), 0.2 * N, 1e-7) << t;
  }
}

// In a round channel, without weight: N = m v^2 / R and v' = -mu v^2 / R, so that v = v_0 / (1 + mu v_0 t / R).
TEST_P(Reactions, FrictionInARoundChannelFollowsTheCentrifugalForce) {
  const std::string text = "gravity = [0, 0, 0]\n" + with(slider, "position = 0.5", "speed = 3") + R"toml(
[measure.r]
type = "distance"
from = "ground"
to = "b"
[constraint.channel]
type = "expression"
value = "r - 0.5"
unit = "m"
[measure.push]
type = "reaction"
quantity = "channel.force"
[measure.v]
type = "expression"
value = "(x.position*z.speed - z.position*x.speed)/0.5"
[force.friction]
type = "force"
marker = "b"
x = "0.3*abs(push)*z.position/0.5"
z = "-0.3*abs(push)*x.position/0.5"
)toml";
  const Series s = run(text, 1, {"v", "push", "x.position"});
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double t = s.t[i], v = 3 / (1 + 0.3 * 3 * t / 0.5),
                 way = 0.5 / 0.3 * std::log(1 + 0.3 * 3 * t / 0.5);
    EXPECT_NEAR(s.values[i](0), v, 3e-6) << t;  // what 1e-9 a step adds up to
    EXPECT_NEAR(s.values[i](1), -2 * v * v / 0.5, 2e-5) << t;
    EXPECT_NEAR(s.values[i](2), 0.5 * std::cos(way / 0.5), 1e-6) << t;
  }
}

// An unbalanced wheel without weight: its journal bears m e omega^2, its friction is mu r times that,
// I omega' = -mu r m e omega^2 with I about the journal.
TEST_P(Reactions, AJournalRubsByTheSizeOfItsLoad) {
  const std::string text = R"toml(
gravity = [0, 0, 0]
[body.wheel]
mass = 3
center = [0.02, 0, 0]
inertia = [0.1, 0.1, 0.2]
[joint.axle]
type = "revolute"
from = "ground"
to = "wheel"
speed = 50
[measure.load]
type = "reaction"
quantity = "axle.force"
guess = 100
[force.friction]
type = "joint_force"
joint = "axle"
value = "-0.4*0.05*load"
)toml";
  const Series s = run(text, 1, {"axle.speed", "load"});
  // The tangential part of the load, m e omega', is -k omega^2 with k = m e (mu r m e / I), and turns the load's direction.
  const double I = 0.2 + 3 * 0.02 * 0.02, me = 3 * 0.02, mr = 0.4 * 0.05;
  // I w' = -mr m e sqrt(w^4 + w'^2): w' = -k w^2 with I k = mr me sqrt(1 + k^2).
  const double q = mr * me / I, k = q / std::sqrt(1 - q * q);
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double w = 50 / (1 + k * 50 * s.t[i]);
    EXPECT_NEAR(s.values[i](0), w, 1e-5) << s.t[i];
    EXPECT_NEAR(s.values[i](1), me * w * w * std::sqrt(1 + k * k), 1e-4) << s.t[i];
  }
}

// A brake whose pad is pressed by a spring, and a motor whose drive is read: the pad holds what the drive gives.
TEST_P(Reactions, OfForcesAndDrivesAreReadAsResultsShowThem) {
  const std::string text = R"toml(
gravity = [0, 0, 0]
[ground.marker.z]
[ground.marker.far]
position = [0, 0, 2]
[body.wheel]
mass = 1
inertia = [1, 1, 0.5]
[body.meter]
mass = 1
inertia = [1, 1, 0.25]
[joint.axle]
type = "revolute"
from = "ground"
to = "wheel"
drive = "3*t + 0.5*t^2"
[joint.meter]
type = "revolute"
from = "ground"
to = "meter"
[force.spring]
type = "spring_damper"
from = "ground.z"
to = "ground.far"
stiffness = 100
free_length = 2.3
[measure.pressed]
type = "reaction"
quantity = "spring.force"
[measure.torque]
type = "reaction"
quantity = "axle.drive_force"
[force.brake]
type = "joint_force"
joint = "axle"
value = "-0.1*abs(pressed)"
[force.copy]
type = "joint_force"
joint = "meter"
value = "torque"
)toml";
  const Series s = run(text, 1, {"pressed", "torque", "meter.angle"});
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    EXPECT_NEAR(std::abs(s.values[i](0)), 30, 1e-9);
    EXPECT_NEAR(s.values[i](1), 0.5 * 1 + 3, 1e-8);
    EXPECT_NEAR(s.values[i](2), 0.5 * 3.5 / 0.25 * s.t[i] * s.t[i], 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(By, Reactions, ::testing::Values("ida", "radau", "runge_kutta", "generalised_alpha"),
                         [](const auto& info) { return info.param; });

class ReactionFiles : public TextCase {};

TEST_F(ReactionFiles, ThatNameNothingAreRefused) {
  EXPECT_THAT(
      refusal(wheel + "[measure.m]\ntype = \"reaction\"\nquantity = \"axle.force_w\"\n"),
      ::testing::AllOf(HasSubstr("\"axle.force_w\" is nothing that a joint"), HasSubstr("did you mean")));
}

// Two hinges in one line bear a door together: how much each does is open, and so would be what its friction does.
TEST_F(ReactionFiles, ThatRedundantHingesShareMoveNothing) {
  const std::string door = R"toml(
[body.door]
mass = 20
center = [0.4, 0, 0]
inertia = [1, 1, 1]
[body.door.marker.low]
position = [0, 0, -0.8]
[ground.marker.low]
position = [0, 0, -0.8]
[joint.high]
type = "revolute"
from = "ground"
to = "door"
speed = 2
[measure.load]
type = "reaction"
quantity = "high.force"
[force.friction]
type = "joint_force"
joint = "high"
value = "-0.003*load*high.speed"
)toml";
  const std::string second = "[joint.low]\ntype = \"revolute\"\nfrom = \"ground.low\"\nto = \"door.low\"\n";
  EXPECT_NO_THROW(prepared(door));
  EXPECT_THAT([&] { prepared(door + second); },
              ThrowsMessage<std::runtime_error>(
                  HasSubstr("formulas read \"load\", which redundant constraints leave open")));
}

TEST_F(ReactionFiles, AConstraintReadsPositionsOnly) {
  EXPECT_THAT(
      refusal(wheel + "[constraint.c]\ntype = \"expression\"\nvalue = \"axle.speed - 2\"\n"),
      HasSubstr("reads \"axle.speed\", a speed; let it read t, parameters, inputs, states of controls, "
                "joint coordinates"));
  for (const std::string jump : {"axle.angle > 1 ? 0.1 : 0", "sign(axle.angle)", "0.1*floor(t)"})
    EXPECT_THAT(
        refusal(wheel + "[constraint.c]\ntype = \"expression\"\nvalue = \"axle.angle - (" + jump + ")\"\n"),
        HasSubstr("holds a comparison, a sign or a rounding"));
  EXPECT_THAT(refusal(wheel + "[constraint.c]\ntype = \"expression\"\nvalue = \"t - 2\"\n"),
              HasSubstr("reads no coordinate"));
  const auto follows = [&](const std::string& control) {
    return refusal(wheel + "[control.f]\n" + control +
                   "[constraint.c]\ntype = \"expression\"\nvalue = \"axle.angle - f\"\n");
  };
  EXPECT_THAT(follows("type = \"sample\"\ninput = \"t\"\nperiod = 1\n"),
              HasSubstr("\"f\" jumps where it switches"));
  EXPECT_THAT(follows("type = \"relay\"\ninput = \"t - 1\"\n"), HasSubstr("\"f\" jumps where it switches"));
  EXPECT_THAT(follows("type = \"pid\"\nerror = \"t\"\n"), HasSubstr("a pid that passes on what it reads"));
  EXPECT_THAT(follows("type = \"filter\"\ninput = \"axle.speed\"\ntime_constant = 1\n"),
              HasSubstr("it reads \"axle.speed\", a speed"));
}

// A cam by a table of heights moved by time, through a measure that is a formula.
TEST_F(ReactionFiles, AConstraintMovesWithTime) {
  const PreparedMechanism p = prepared(wheel + R"toml([measure.wanted]
type = "expression"
value = "sin(axle.angle) - 0.3*t^2"
[constraint.law]
type = "expression"
value = "wanted"
)toml" + "[solver]\nend_time = 1\noutput_step = 0.1\ntolerance = 1e-9\n");
  const Series s = simulate(p, {"axle.angle", "axle.speed", "axle.acceleration", "law.force"});
  for (std::size_t i = 1; i < s.t.size(); ++i) {
    const double t = s.t[i], sine = 0.3 * t * t, cosine = std::sqrt(1 - sine * sine), rate = 0.6 * t / cosine,
                 second = (0.6 + sine * rate * rate) / cosine;
    EXPECT_NEAR(s.values[i](0), std::asin(sine), 1e-8);
    EXPECT_NEAR(s.values[i](1), rate, 1e-6);
    EXPECT_NEAR(s.values[i](2), second, 1e-5);
    EXPECT_NEAR(s.values[i](3) * cosine, 0.5 * second, 1e-5);
  }
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-6);
}

}  // namespace
}  // namespace flexura::mbs::cases
