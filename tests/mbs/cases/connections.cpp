// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <cmath>

#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/linear/descriptor.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "tests/mbs/cases/text_case.hpp"

/// Connections, inputs and actuators against exact answers.
namespace flexura::mbs::cases {
namespace {

using ::testing::HasSubstr;

class Connections : public TextCase {};
class Inputs : public TextCase {};
class Actuators : public TextCase {};

const std::string door = R"toml(
gravity = [0, 0, -9.81]
[ground.marker.top]
position = [0, 0, 2]
[body.door]
mass = 20
center = [0.4, 0, 1]
inertia = [7, 8, 1.2]
[body.door.marker.top]
position = [0, 0, 2]
)toml";

TEST_F(Connections, TheOneWithTheFewestFreedomsLeadsAndTheOthersConstrain) {
  const PreparedMechanism p = prepared(door + R"toml(
[connection.top]
type = "point_on_line"
from = "ground.top"
to = "door.top"
z = 0.3
[connection.bottom]
type = "revolute"
from = "ground"
to = "door"
speed = 2
)toml" + solver);
  ASSERT_EQ(p.mechanism->description().joints[0].name, "top");
  EXPECT_FALSE(p.mechanism->in_tree(0));
  EXPECT_TRUE(p.mechanism->in_tree(1));
  EXPECT_EQ(p.mechanism->sizes().n_v, 1);
  // The upper point stays on the axis of the hinge anyway.
  EXPECT_EQ(p.redundant.size(), 2u);
  const Series s = simulate(p, {"bottom.angle"});
  for (std::size_t i = 0; i < s.t.size(); ++i) EXPECT_NEAR(s.values[i](0), 2.0 * s.t[i], 1e-9);
}

TEST_F(Connections, ABodyOnAPlaneNeedsNoConstraint) {
  // Thrown along a plane of 30 degrees: a parabola in it, spinning freely about its centre.
  const PreparedMechanism p = prepared(R"toml(
gravity = [0, 0, -9.81]
[ground.marker.slope]
axis = [0, "-sin(pi/6)", "cos(pi/6)"]
x_axis = [1, 0, 0]
[body.disc]
mass = 2
inertia = [0.1, 0.1, 0.1]
[connection.slide]
type = "point_on_plane"
from = "ground.slope"
to = "disc"
v_x = 1
v_y = 3
omega_z = 5
)toml" + solver);
  EXPECT_EQ(p.mechanism->sizes().n_v, 5);
  EXPECT_EQ(p.mechanism->sizes().n_lambda, 0);
  const Series s = simulate(p, {"slide.x", "slide.y", "slide.omega_z"});
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double t = s.t[i];
    EXPECT_NEAR(s.values[i](0), t, 1e-8);
    EXPECT_NEAR(s.values[i](1), 3 * t - 0.25 * 9.81 * t * t, 1e-8);
    EXPECT_NEAR(s.values[i](2), 5.0, 1e-9);
  }
  EXPECT_THAT(
      refusal(door + "[connection.a]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"door\"\ncut = true\n"),
      HasSubstr("unknown key"));
  EXPECT_THAT(refusal(wheel + "[connection.axle]\ntype = \"fixed\"\nfrom = \"ground\"\nto = \"wheel\"\n"),
              HasSubstr("has the name of a joint"));
}

const std::string driven = wheel + R"toml(
[parameters]
k = 8
[force.spring]
type = "joint_spring_damper"
joint = "axle"
stiffness = "k"
[force.motor]
type = "joint_force"
joint = "axle"
value = "4*torque + brake"
[input.torque]
value = "sin(t)"
[input.brake]
[output]
y = ["axle.acceleration", "axle.angle"]
)toml";

TEST_F(Inputs, DriveTheMotionAndAreColumnsOfB) {
  const PreparedMechanism p = prepared(driven + solver);
  ASSERT_EQ(p.mechanism->n_inputs(), 2);
  EXPECT_EQ(p.file.y, (std::vector<std::string>{"axle.acceleration", "axle.angle"}));
  // J = 0.5: q'' + 16 q = 8 sin(t) from rest: q = 8 / 15 (sin(t) - sin(4 t) / 4).
  const Series s = simulate(p, {"axle.angle", "torque"});
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    EXPECT_NEAR(s.values[i](0), 8.0 / 15.0 * (std::sin(s.t[i]) - 0.25 * std::sin(4 * s.t[i])), 1e-8);
    EXPECT_DOUBLE_EQ(s.values[i](1), std::sin(s.t[i]));
  }
  LineariseOptions options;
  options.signals = {0, 1};
  const auto which = select_quantities(*p.mechanism, p.file.y);
  const auto scratch = p.mechanism->make_scratch();
  options.output_names = p.file.y;
  options.outputs = [&](const State& at, const Eigen::VectorXd& v_dot) {
    Eigen::VectorXd y(2);
    p.mechanism->evaluate(which, at, v_dot, *scratch, y);
    return y;
  };
  const LinearSystem linear = linearise(*p.mechanism, p.state, options);
  EXPECT_EQ(linear.inputs, (std::vector<std::string>{"torque", "brake"}));
  // Central differences of a linear system: round-off of 1e-16 / 1e-5.
  EXPECT_NEAR(linear.B(1, 0), 8.0, 1e-8);
  EXPECT_NEAR(linear.B(1, 1), 2.0, 1e-8);
  EXPECT_NEAR(linear.D(0, 0), 8.0, 1e-8);
  EXPECT_NEAR(linear.D(1, 0), 0.0, 1e-12);
  EXPECT_NEAR(linear.C(0, 0), -16.0, 1e-8);
  const DescriptorSystem descriptor = linearise_as_descriptor(*p.mechanism, p.state, options);
  EXPECT_NEAR(descriptor.B(1, 0), 4.0, 1e-8);
  EXPECT_NEAR(descriptor.D(0, 1), 2.0, 1e-8);
  EXPECT_THAT(refusal(driven + "[control.torque]\ntype = \"state\"\nrate = \"1\"\n"), HasSubstr("is taken"));
}

TEST_F(Actuators, FollowTheirCommandWithALag) {
  const PreparedMechanism p = prepared(wheel + R"toml(
[force.motor]
type = "actuator"
joint = "axle"
command = "3"
time_constant = "0.25 s"
)toml" + solver);
  EXPECT_EQ(p.mechanism->sizes().n_dyn, 1);
  const Series s = simulate(p, {"motor.force", "axle.speed"});
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double t = s.t[i], lag = std::exp(-4 * t);
    EXPECT_NEAR(s.values[i](0), 3 * (1 - lag), 1e-7);
    EXPECT_NEAR(s.values[i](1), 6 * (t - 0.25 * (1 - lag)), 1e-7);
  }
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-7);
}

TEST_F(Actuators, RunUpToTheirNoLoadSpeedAndNoFurther) {
  const PreparedMechanism p = prepared(wheel + R"toml(
[force.motor]
type = "actuator"
joint = "axle"
command = "1000"
time_constant = "1e-5 s"
start = 2
max_force = 2
no_load_speed = 10
)toml" + solver);
  const Series s = simulate(p, {"axle.speed"});
  // J v' = F (1 - v / v_0): v = v_0 (1 - exp(-F t / (J v_0))); the lag shifts it by 1e-5 s at 4 rad/s^2.
  for (std::size_t i = 0; i < s.t.size(); ++i)
    EXPECT_NEAR(s.values[i](0), 10 * (1 - std::exp(-0.4 * s.t[i])), 1e-4);
  EXPECT_THAT(refusal(wheel + "[force.m]\ntype = \"actuator\"\ncommand = \"1\"\ntime_constant = 1\n"),
              HasSubstr("acts on nothing"));
  EXPECT_THAT(
      refusal(wheel + "[force.m]\ntype = \"actuator\"\njoint = \"axle\"\ncommand = \"1\"\ntime_constant = 1\n"
                      "no_load_speed = 3\n"),
      HasSubstr("needs max_force"));
}

}  // namespace
}  // namespace flexura::mbs::cases
