// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mbs/mechanism/describe.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/mechanism_file.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;

TEST_F(MechanismFileTest, ConstraintsSatisfyAllIdentities) {
  const std::string frame = kThreeBodies + std::string("[constraint.c]\n");
  const char* constraints[] = {
      R"toml(type = "point_on_line"
from = "a.out"
to = "b.in")toml",
      R"toml(type = "point_on_plane"
from = "ground"
to = "b.in")toml",
      R"toml(type = "point_on_curve"
from = "a.out"
to = "b.in"
points = [[1, 0, 0], [0.8, 0.9, 0.3], [-0.2, 1.4, 0.5], [-1.2, 0.3, 0.1], [-0.5, -1, -0.4], [0.6, -0.8, -0.2]]
closed = true)toml",
      R"toml(type = "point_on_path"
path = ["a.rail_1", "a.rail_2", "a.out", "a.rail_3"]
to = "b.in"
ends = "straight"
[body.a.marker.rail_1]
position = [-0.9, -0.2, 0]
[body.a.marker.rail_2]
position = [-0.3, 0.3, 0.1]
rotation = [0.3, 0.2, 1]
[body.a.marker.rail_3]
position = [0.9, 0.4, -0.2])toml",
      R"toml(type = "point_on_path"
path = ["a.rail_1", "a.rail_2", "a.out", "a.rail_3"]
to = "b.in"
orientation = "fixed"
place = "0.9 + 0.3*sin(2*t)"
[body.a.marker.rail_1]
position = [-0.9, -0.2, 0]
[body.a.marker.rail_2]
position = [-0.3, 0.3, 0.1]
rotation = [0.3, 0.2, 1]
[body.a.marker.rail_3]
position = [0.9, 0.4, -0.2])toml",
      R"toml(type = "orientation"
from = "b.in"
to = "ground")toml",
      R"toml(type = "parallel"
from = "a.out"
to = "b.in")toml",
      R"toml(type = "perpendicular"
from = "ground.track"
to = "b.in")toml",
      R"toml(type = "distance"
from = "ground.track"
to = "b.in"
length = "700 mm")toml",
      R"toml(type = "coupler"
joints = ["second.angle", "second.position", "third"]
factors = [1, 2, 0.5]
offset = "sin(2*t)")toml",
      R"toml(type = "gear"
joint_1 = "second.angle"
joint_2 = "third"
teeth_1 = 17
teeth_2 = 40
internal = true)toml",
      R"toml(type = "rack_and_pinion"
rack = "third"
pinion = "second.angle"
radius = "30 mm")toml",
      R"toml(type = "rolling_disc"
from = "ground.track"
to = "b.in"
radius = "300 mm")toml"};
  for (const char* constraint : constraints) {
    SCOPED_TRACE(constraint);
    const Mechanism mechanism(read(frame + constraint).description);
    ASSERT_GT(mechanism.sizes().n_lambda, 0);
    for (unsigned seed : {3u, 4u}) all_identities_hold(mechanism, seed);
  }
}

TEST_F(MechanismFileTest, ControlsHoldStatesAndFeedForces) {
  const Mechanism mechanism(read(R"toml(
[parameters]
gain = 7
[body.cart]
mass = 2
[joint.rail]
type = "prismatic"
from = "ground"
to = "cart"
position = "0.5 m"
speed = "0.25 m/s"
[control.ramp]           # two coupled equations of the user's own
type = "state"
rate = "-2*ramp + other"
start = "gain - 1"
[control.other]
type = "state"
rate = "-ramp + rail.speed"
[measure.seen]
type = "expression"
value = "smooth + rail.position"
[control.smooth]
type = "filter"
input = "rail.position"
time_constant = "20 ms"
start = 0.1
[control.loop]
type = "pid"
error = "1 - rail.position"
proportional = "gain"
integral = 3
derivative = 0.5
filter_time = "10 ms"
upper = 30
[control.plant]
type = "transfer_function"
input = "loop"
numerator = [2, 1]
denominator = [5, 3, 4]
[force.push]
type = "joint_force"
joint = "rail"
value = "loop + plant + 10*seen + ramp"
)toml")
                                .description);
  ASSERT_EQ(mechanism.sizes().n_dyn, 7);
  State s = mechanism.initial_state();
  EXPECT_EQ(mechanism.name_of_dynamic(0), "ramp");
  EXPECT_EQ(mechanism.name_of_dynamic(6), "plant.state_2");
  EXPECT_DOUBLE_EQ(s.c(0), 6.0);
  EXPECT_DOUBLE_EQ(s.c(2), 0.1);
  s.c << 6.0, 0.5, 0.1, 0.2, 0.3, 0.4, -0.6;
  const auto scratch = mechanism.make_scratch();
  VectorXd r(1), c_rate(7), none(0);
  mechanism.momentum(s, VectorXd::Zero(1), *scratch, r, c_rate, none);
  const double e = 0.5, loop = 7 * e + 3 * 0.2 + 0.5 * (e - 0.3) / 0.01, plant = 2 * 0.4 - 0.6;
  EXPECT_DOUBLE_EQ(c_rate(0), -2 * 6.0 + 0.5);
  EXPECT_DOUBLE_EQ(c_rate(1), -6.0 + 0.25);
  EXPECT_DOUBLE_EQ(c_rate(2), (0.5 - 0.1) / 0.02);
  EXPECT_DOUBLE_EQ(c_rate(3), e);
  EXPECT_DOUBLE_EQ(c_rate(4), (e - 0.3) / 0.01);
  EXPECT_DOUBLE_EQ(c_rate(5), -0.6);
  EXPECT_DOUBLE_EQ(c_rate(6), (loop - 5 * 0.4 - 3 * -0.6) / 4);
  // The rail is vertical: the weight adds to the force needed.
  const double push = loop + plant + 10 * (0.1 + 0.5) + 6.0;
  EXPECT_NEAR(r(0), 2 * 9.81 - push, 1e-13 * push);
  // Past its limit the controller holds its integral.
  s.c(3) = 100.0;
  mechanism.momentum(s, VectorXd::Zero(1), *scratch, r, c_rate, none);
  EXPECT_DOUBLE_EQ(c_rate(3), 0.0);
  EXPECT_NEAR(r(0), 2 * 9.81 - (30.0 + push - loop), 1e-13 * push);
  VectorXd value(1);
  mechanism.evaluate(select_quantities(mechanism, {"loop"}), s, VectorXd::Zero(1), *scratch, value);
  EXPECT_DOUBLE_EQ(value(0), 30.0);
}

// What a formula is a quantity of is the user's to say; energies are told from torques.
TEST_F(MechanismFileTest, FormulasAndEnergiesHaveTheirUnits) {
  const auto unit = [&](const std::string& key, const std::string& name) {
    const Mechanism mechanism(
        read("[body.cart]\nmass = 2\n[joint.rail]\ntype = \"prismatic\"\nfrom = \"ground\"\nto = \"cart\"\n"
             "drive = \"t\"\n[measure.pull]\ntype = \"expression\"\nvalue = \"2*t\"\n" +
             key)
            .description);
    for (const OutputInfo& info : mechanism.quantities())
      if (info.name == name) return unit_of(info);
    for (const OutputInfo& info : run_quantities())
      if (info.name == name) return unit_of(info);
    return std::string("no such quantity");
  };
  EXPECT_EQ(unit("", "pull"), "");
  EXPECT_EQ(unit("unit = \"N\"\n", "pull"), "N");
  EXPECT_EQ(unit("unit = \"N*m/rad\"\n", "pull"), "N*m/rad");
  EXPECT_EQ(unit("unit = \"kg*m/s^2\"\n", "pull"), "N");
  EXPECT_EQ(unit("[input.speed]\nunit = \"rad/s\"\n", "speed"), "rad/s");
  const std::string late = "[control.late]\ntype = \"filter\"\ninput = \"pull\"\ntime_constant = 0.1\n";
  EXPECT_EQ(unit(late, "late"), "");
  EXPECT_EQ(unit(late + "unit = \"N\"\n", "late"), "N");
  for (const char* energy : {"energy.kinetic", "energy.total", "energy.balance"})
    EXPECT_EQ(unit("", energy), "J") << energy;
  EXPECT_EQ(unit("", "rail.torque"), "N*m");
  // Formulas are in SI: 1 N shown as 1 kN would be a lie.
  for (const char* wrong : {"kN", "mm", "deg", "newton", ""}) {
    try {
      unit("unit = \"" + std::string(wrong) + "\"\n", "pull");
      ADD_FAILURE() << "taken: " << wrong;
    } catch (const input::InputError& refused) {
      EXPECT_THAT(refused.what(), ::testing::HasSubstr("unit")) << refused.what();
    }
  }
}

}  // namespace
}  // namespace flexura::mbs
