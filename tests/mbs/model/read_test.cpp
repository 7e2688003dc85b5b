// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include "mbs/mechanism/describe.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/mechanism_file.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;
using ::testing::HasSubstr;

const char* const slider_crank = R"toml(
name = "slider crank"
gravity = [0, "-9.81 m/s^2", 0]
[parameters]
pull = "2*base"        # may read what stands below
base = "3 N"
[ground.marker.guide]
axis = [1, 0, 0]
[body.crank]
mass = "500 g"
center = ["50 mm", 0, 0]
inertia = ["1e-4 kg*m^2", "4e-4 kg*m^2", "4e-4 kg*m^2"]
[body.crank.marker.pin]
position = ["100 mm", 0, 0]
[body.rod]
mass = 0.8
inertia = [1e-4, 8e-3, 8e-3]
[body.rod.marker.end]
position = [0.35, 0, 0]
[body.slider]
mass = 1.2
[body.slider.marker.guide]
axis = [1, 0, 0]
[joint.shaft]
type = "hinge"
from = "ground"
to = "crank"
angle = "30 deg"
speed = "10 rad/s"
[joint.pin]
type = "revolute"
from = "crank.pin"
to = "rod"
[joint.guide]
type = "prismatic"
from = "ground.guide"
to = "slider.guide"
position = "430 mm"
[joint.wrist]
type = "revolute"
from = "rod.end"
to = "slider"
[measure.gap]
type = "distance"
from = "crank.pin"
to = "slider"
[measure.twice]
type = "expression"
value = "2*gap + shaft.speed"
[force.spring]
type = "spring_damper"
from = "ground"
to = "rod.end"
stiffness = "1 N/mm"
damping = "5 N*s/m"
free_length = "20 cm"
[force.push]
type = "force"
marker = "rod.end"
x = "pull*sin(3*t) - 0.1*twice"
z = "1 N"
axes = "crank.pin"
reaction = "crank.pin"
[force.wind]
type = "torque"
marker = "rod"
y = "base*guide.speed"
[force.brake]
type = "joint_force"
joint = "shaft"
value = "-0.3*shaft.speed"
[force.coil]
type = "joint_spring_damper"
joint = "wrist"
stiffness = "4 N*m/rad"
damping = "0.2 N*m*s/rad"
rest = "20 deg"
[force.rubbing]
type = "joint_friction"
joint = "guide"
coulomb = "3 N"
static = "5 N"
stribeck_speed = "2 m/s"
transition_speed = "1 m/s"
viscous = 0.1
[force.rubber]
type = "bushing"
from = "crank.pin"
to = "slider.guide"
stiffness = ["200 N/m", "300 N/m", "150 N/m"]
rotational_stiffness = ["20 N*m/rad", "30 N*m/rad", "10 N*m/rad"]
damping = [2, 3, 4]
rotational_damping = ["1 N*m*s/rad", "0.5 N*m*s/rad", "0.1 N*m*s/rad"]
[run.light]
set = ["body.rod.mass=0.1"]
)toml";

TEST_F(MechanismFileTest, IsReadWithUnitsParametersAndSynonyms) {
  const MechanismFile file = read(slider_crank);
  const Mechanism mechanism(file.description);
  EXPECT_EQ(file.name, "slider crank");
  EXPECT_EQ(mechanism.sizes().n_v, 3);
  EXPECT_EQ(mechanism.sizes().n_lambda, 5);
  const State s = mechanism.initial_state();
  for (int i = 0; i < 3; ++i) {
    if (mechanism.name_of_position(i) == "shaft.angle") {
      EXPECT_DOUBLE_EQ(s.p(i), M_PI / 6);
      EXPECT_TRUE(mechanism.given_positions()[i]);
      EXPECT_DOUBLE_EQ(s.v(i), 10.0);
    }
    if (mechanism.name_of_position(i) == "pin.angle") {
      EXPECT_FALSE(mechanism.given_positions()[i]);
    }
  }
  ASSERT_EQ(file.runs.size(), 1u);
  EXPECT_EQ(file.runs[0].overrides, std::vector<std::string>{"body.rod.mass=0.1"});
  const MechanismFile light = read(slider_crank, file.runs[0].overrides);
  EXPECT_DOUBLE_EQ(light.description.bodies[2].inertia.mass, 0.1);
}

TEST_F(MechanismFileTest, ForcesSatisfyAllIdentities) {
  const Mechanism mechanism(read(slider_crank).description);
  for (unsigned seed : {1u, 2u}) all_identities_hold(mechanism, seed);
}

TEST_F(MechanismFileTest, QuantitiesAgreeWithTheirOwnFormulas) {
  const Mechanism mechanism(read(slider_crank).description);
  State s = random_state(mechanism, 3);
  const auto scratch = mechanism.make_scratch();
  const std::vector<OutputInfo> infos = mechanism.quantities();
  std::vector<int> all(infos.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  VectorXd values(all.size());
  const VectorXd v_dot = Random(4).vector(3);
  mechanism.evaluate(all, s, v_dot, *scratch, values);
  const auto get = [&](const std::string& name) {
    for (std::size_t i = 0; i < infos.size(); ++i)
      if (infos[i].name == name) return values(i);
    ADD_FAILURE() << "no quantity " << name;
    return 0.0;
  };
  EXPECT_DOUBLE_EQ(get("twice"), 2 * get("gap") + get("shaft.speed"));
  EXPECT_DOUBLE_EQ(get("push.x"), 6.0 * std::sin(3 * s.t) - 0.1 * get("twice"));
  EXPECT_DOUBLE_EQ(get("wind.y"), 3.0 * get("guide.speed"));
  EXPECT_DOUBLE_EQ(get("brake.force"), -0.3 * get("shaft.speed"));
  EXPECT_NEAR(get("spring.force") - 1000.0 * (get("spring.length") - 0.2), 0.0,
              5.0 * 30);  // the damper's share
  EXPECT_DOUBLE_EQ(get("energy.total"),
                   get("energy.kinetic") + get("energy.strain") + get("energy.potential"));
  EXPECT_DOUBLE_EQ(get("guide.force"),
                   std::hypot(get("guide.force_x"), get("guide.force_y"), get("guide.force_z")));
  // The pin closes the loop (the wrist, which carries a spring, is in the tree): its reaction on the rod is minus
  // G^T lambda, in the axes of the crank's marker.
  Vector3d lambda_force = -s.lambda.head<3>();
  EXPECT_NEAR(get("pin.force"), lambda_force.norm(), 1e-13 * lambda_force.norm());

  EXPECT_EQ(select_quantities(mechanism, {"energy.*"}).size(), 4u);
  EXPECT_FALSE(select_quantities(mechanism, {}).empty());
  try {
    select_quantities(mechanism, {"shaft.angel"});
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "there is no quantity \"shaft.angel\", did you mean \"shaft.angle\"?");
  }
  EXPECT_THAT(connections_json(mechanism), HasSubstr("\"body_1\":\"crank\""));
}

TEST_F(MechanismFileTest, ReactionsCarryAHangingWeight) {
  // A weight hung on a fixed joint that is written from the weight to ground (reversed in the tree): the
  // force on ground, the body of `to`, is the weight's; its lever about ground's marker makes the torque.
  for (const bool reversed : {false, true}) {
    const std::string ends =
        reversed ? "from = \"weight\"\nto = \"ground\"\n" : "from = \"ground\"\nto = \"weight\"\n";
    const Mechanism mechanism(
        read("[body.weight]\nmass = 2\ncenter = [0.3, 0, 0]\n[joint.hook]\ntype = \"weld\"\n" + ends)
            .description);
    State s = mechanism.initial_state();
    const auto scratch = mechanism.make_scratch();
    VectorXd values(5);
    mechanism.evaluate(select_quantities(mechanism, {"hook.force_z", "hook.torque_y", "hook.force",
                                                     "hook.torque", "energy.potential"}),
                       s, VectorXd(0), *scratch, values);
    const double sign =
        reversed ? -1.0 : 1.0;  // on ground the weight pulls down, on the weight the hook pulls up
    EXPECT_DOUBLE_EQ(values(0), sign * 2 * 9.81);
    EXPECT_DOUBLE_EQ(values(1), -sign * 0.3 * 2 * 9.81);
    EXPECT_DOUBLE_EQ(values(2), 2 * 9.81);
    EXPECT_DOUBLE_EQ(values(3), 0.3 * 2 * 9.81);
    EXPECT_DOUBLE_EQ(values(4), 0.0);
  }
}

TEST_F(MechanismFileTest, DrivesAndFreeBodiesStartAsTold) {
  const Mechanism mechanism(read(R"toml(
[body.stone]
mass = 1
inertia = [1, 1, 1]
position = [1, 2, 3]
axis = [0, 0, -1]
velocity = [0, 5, 0]
angular_velocity = [0, 0, "1 deg/s"]
[body.arm]
mass = 1
inertia = [1, 1, 1]
[joint.motor]
type = "revolute"
from = "ground"
to = "arm"
drive = "30 * t + 0.5 + 0.1*sin(t)"
)toml")
                                .description);
  const State s = mechanism.initial_state();
  EXPECT_EQ(mechanism.sizes().n_lambda, 1);
  EXPECT_EQ(mechanism.name_of_constraint(0), "motor.drive");
  for (int i = 0; i < mechanism.sizes().n_p; ++i) {
    if (mechanism.name_of_position(i) == "motor.angle") {
      EXPECT_DOUBLE_EQ(s.p(i), 0.5);
    }
    if (mechanism.name_of_position(i) == "stone.y") {
      EXPECT_DOUBLE_EQ(s.p(i), 2.0);
    }
  }
  for (int i = 0; i < mechanism.sizes().n_v; ++i) {
    if (mechanism.name_of_velocity(i) == "motor.speed") {
      EXPECT_DOUBLE_EQ(s.v(i), 30.1);
    }
    if (mechanism.name_of_velocity(i) == "stone.v_y") {
      EXPECT_DOUBLE_EQ(s.v(i), 5.0);
    }
    if (mechanism.name_of_velocity(i) == "stone.omega_z") {
      EXPECT_DOUBLE_EQ(s.v(i), M_PI / 180);
    }
  }
}

TEST_F(MechanismFileTest, NumbersAreFormulasOfTheParameters) {
  const std::string text = R"toml(
[parameters]
r = "20 mm"
n = 3
[body.b]
mass = "n/2"
center = ["2*r", 0, "-r"]
[joint.j]
type = "revolute"
from = "ground"
to = "b"
speed = "pi/n"
)toml";
  const MechanismDescription d = read(text).description;
  EXPECT_DOUBLE_EQ(d.bodies[1].inertia.mass, 1.5);
  EXPECT_TRUE(d.bodies[1].inertia.mass_center.isApprox(1.5 * Vector3d(0.04, 0.0, -0.02), 1e-15));
  EXPECT_DOUBLE_EQ(d.joints[0].initial_speeds.at(0), M_PI / 3);
  EXPECT_DOUBLE_EQ(read(text, {"parameters.n=4"}).description.bodies[1].inertia.mass, 2.0);
  EXPECT_EQ(test::refusal_of([&] { read(text, {"parameters.m=4"}); }),
            "command line: parameters.m: the file's parameters have no \"m\"; known are n, r");

  const auto with_mass = [&](const std::string& mass) {
    return refusal("[parameters]\nradius = 1\n[body.b]\nmass = \"" + mass + "\"\n");
  };
  EXPECT_THAT(with_mass("2*radus"),
              HasSubstr("m.toml:4: body.b.mass = \"2*radus\": \"radus\" is not known here, "
                        "did you mean \"radius\"?"));
  EXPECT_THAT(with_mass("radius*t"), HasSubstr("varies with t where a number is wanted"));
  EXPECT_THAT(with_mass("1/(radius - 1)"), HasSubstr("body.b.mass = \"1/(radius - 1)\": is inf"));
  EXPECT_THAT(with_mass("-radius"), HasSubstr("must be at least 0"));
  EXPECT_THAT(with_mass("2 kq"), HasSubstr("unknown unit"));
}

TEST_F(MechanismFileTest, RefusalsNameLineValueAndRemedy) {
  const std::string two = "[body.crank]\nmass = 1\n[body.rod]\nmass = 1\n[body.rod.marker.left]\n";
  EXPECT_THAT(
      refusal(two + "[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"cranc\"\n"),
      HasSubstr("m.toml:9: joint.j.to = \"cranc\": there is no body \"cranc\", did you mean \"crank\"?"));
  EXPECT_THAT(refusal(two + "[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"rod.lefd\"\n"),
              HasSubstr("body \"rod\" has no marker \"lefd\", did you mean \"rod.left\"?"));
  EXPECT_THAT(refusal(two + "[joint.j]\ntype = \"revolut\"\nfrom = \"ground\"\nto = \"rod\"\n"),
              HasSubstr("did you mean \"revolute\"?"));
  EXPECT_THAT(refusal(two + "[joint.j]\ntype = \"fixed\"\nfrom = \"rod\"\nto = \"rod.left\"\n"),
              HasSubstr("\"rod.left\" is a marker of the same body as \"rod\"; a joint joins two bodies"));
  EXPECT_THAT(refusal("[body.b]\nmass = -1\n"), HasSubstr("m.toml:2: body.b.mass = -1"));
  EXPECT_THAT(refusal("[body.b]\ncenter = [0, 0, 0]\n"), HasSubstr("has neither mass nor superelement"));
  EXPECT_THAT(refusal("[body.b]\nmass = \"3 mm\"\n"), HasSubstr("is a length, a mass is wanted"));
  EXPECT_THAT(refusal("[body.b]\nmass = 1\ninertia = [1, -1, 1]\n"),
              HasSubstr("has the principal moments -1, 1, 1 kg m^2: none can be negative"));
  EXPECT_THAT(
      refusal("[body.b]\nmass = 1\ninertia = [1, 1, 5]\n"),
      HasSubstr("m.toml:3: body.b.inertia = [1, 1, 5]: has the principal moments 1, 1, 5 kg m^2: the two "
                "smaller ones together cannot be less than the largest, I1 + I2 >= I3; check the values"));
  // A flat body with three digits, a rod without a moment about itself.
  for (const char* const thin : {"[0.333, 0.333, 0.667]", "[0, 2, 2]"})
    EXPECT_NO_THROW(read(std::string("[body.b]\nmass = 1\ninertia = ") + thin + "\n"));
  // The diagonal alone is possible, the tensor is not.
  EXPECT_THAT(refusal("[body.b]\nmass = 1\ninertia = [2, 2, 2, 1.2, 0, 0]\n"),
              HasSubstr("has the principal moments 0.8, 2, 3.2 kg m^2"));
  EXPECT_THAT(refusal("[body.b]\nsuperelement = \"none.se.h5\"\n"), HasSubstr("none.se.h5"));
  EXPECT_THAT(
      refusal("[body.b]\nmass = 1\n[force.f]\ntype = \"force\"\nmarker = \"b\"\nx = \"3*b.postion_x\"\n"),
      HasSubstr("m.toml:6: force.f.x = \"3*b.postion_x\": \"b.postion_x\" is not known here"));
  EXPECT_THAT(refusal("[parameters]\na = \"b\"\nb = \"2*a\"\n"),
              HasSubstr("a, b depend on each other in a circle"));
  EXPECT_THAT(refusal("[parameters]\na = \"1/0\"\n"), HasSubstr("parameters.a = \"1/0\" is inf"));
  EXPECT_THAT(refusal("[body.b]\nmass = 1\n[joint.j]\ntype = \"revolute\"\nfrom = \"ground\"\nto = \"b\"\n"
                      "drive = \"t\"\nangle = 1\n"),
              HasSubstr("joint.j.angle = 1: the coordinate is driven; take this key away"));
  EXPECT_THAT(refusal("[body.b]\nmass = 1\nmodes = 3\n"), HasSubstr("a rigid body has no modes"));
  EXPECT_THAT(refusal("[body.b]\nmass = 1\n[body.b.marker.m]\non = \"tip\"\n"),
              HasSubstr("the body has no interface \"tip\"; only superelements have interfaces"));
  EXPECT_THAT(
      refusal("[body.b]\nmass = 1\n[joint.j]\ntype = \"ball\"\nfrom = \"ground\"\nto = \"b\"\n[force.f]\n"
              "type = \"joint_force\"\njoint = \"j\"\nvalue = 1\n"),
      HasSubstr("a spherical joint has no coordinate that can be acted on alone"));
}

// Each would hide what the other has.
TEST_F(MechanismFileTest, TwoElementsWithQuantitiesOfOneNameAreRefused) {
  const std::string wheel =
      "[body.wheel]\nmass = 1\ninertia = [1, 1, 1]\n[joint.hinge]\ntype = \"revolute\"\nfrom = "
      "\"ground\"\nto = \"wheel\"\n";
  const auto refusal_of = [&](const std::string& more) {
    return test::refusal_of([&] {
      const Mechanism m(read(wheel + more).description);
      m.quantities();
    });
  };
  const std::string spring = "type = \"joint_spring_damper\"\njoint = \"hinge\"\nstiffness = 100\n";
  EXPECT_THAT(refusal_of("[force.hinge]\n" + spring),
              HasSubstr("\"hinge.force\" is a quantity of joint \"hinge\" and of force \"hinge\""));
  EXPECT_EQ(refusal_of("[force.spring]\n" + spring), "accepted");
}

}  // namespace
}  // namespace flexura::mbs
