// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "mbs/model/read_mechanism.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;
using ::testing::HasSubstr;

input::TableSchema no_solver() {
  input::TableSchema schema;
  schema.name = "solver";
  return schema;
}

class MechanismFileTest : public ::testing::Test {
 protected:
  MechanismFileTest() {
    directory_ =
        std::filesystem::temp_directory_path() /
        ("flexura_model_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(directory_);
  }
  ~MechanismFileTest() override { std::filesystem::remove_all(directory_); }

  MechanismFile read(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::ofstream(directory_ / "m.toml") << text;
    return read_mechanism(directory_ / "m.toml", no_solver(), overrides);
  }
  std::string refusal(const std::string& text) const {
    try {
      read(text);
    } catch (const input::InputError& error) {
      return error.what();
    }
    return "accepted";
  }

  std::filesystem::path directory_;
};

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
  // The wrist closes the loop: its reaction on the slider is minus G^T lambda, in the axes of the rod's
  // marker.
  Vector3d lambda_force = -s.lambda.head<3>();
  EXPECT_NEAR(get("wrist.force"), lambda_force.norm(), 1e-13 * lambda_force.norm());

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

const char* const flexible_pendulum = R"toml(
[body.beam]
superelement = "beam.se.h5"
damping = 0.02
[body.beam.marker.tip]
on = "right"
position = [1.0, 0.2, 0.3]
[body.bob]
mass = 1
inertia = [0.1, 0.1, 0.1]
[joint.pivot]
type = "revolute"
from = "ground"
to = "beam.left"
[joint.neck]
type = "ball"
from = "beam.tip"
to = "bob"
[force.gust]
type = "force"
marker = "beam.tip"
axes = "beam.tip"
x = "sin(t)"
reaction = "bob"
)toml";

TEST_F(MechanismFileTest, SuperelementIsModalOrRigid) {
  const lattice::Lattice l = lattice::make_lattice(3);
  superelement::write(directory_ / "beam.se.h5", l.se);
  const MechanismFile file = read(flexible_pendulum);
  const Mechanism modal(file.description);
  EXPECT_EQ(modal.sizes().n_flx, l.se.n() - 6);
  EXPECT_TRUE(file.notes.empty());
  all_identities_hold(modal, 5);
  const Mechanism rigid(read(flexible_pendulum, {"body.beam.fidelity=rigid"}).description);
  EXPECT_EQ(rigid.sizes().n_flx, 0);
  all_identities_hold(rigid, 6);
  // Undeformed, both have the same pose everywhere and the same rigid mass matrix.
  const State s_m = modal.initial_state(), s_r = rigid.initial_state();
  const auto scratch_m = modal.make_scratch(), scratch_r = rigid.make_scratch();
  std::vector<Pose> poses_m, poses_r;
  modal.body_poses(s_m, *scratch_m, poses_m);
  rigid.body_poses(s_r, *scratch_r, poses_r);
  for (int b = 1; b < 3; ++b) EXPECT_LE((poses_m[b].p - poses_r[b].p).norm(), 1e-14);

  const MechanismFile truncated = read(flexible_pendulum, {"body.beam.modes=4"});
  EXPECT_EQ(Mechanism(truncated.description).sizes().n_flx, 4);
  ASSERT_EQ(truncated.notes.size(), 1u);
  EXPECT_THAT(truncated.notes[0], HasSubstr("body \"beam\" keeps 4 of 9 modes"));
  EXPECT_THAT(truncated.notes[0], HasSubstr("it is stiffer under loads"));
}

TEST_F(MechanismFileTest, BodiesArePreparedForWhatActsOnThem) {
  const lattice::Lattice l = lattice::make_lattice(12);  // 24 shapes, 18 deformations
  superelement::write(directory_ / "beam.se.h5", l.se);
  const auto modes_of = [&](const std::vector<std::string>& overrides) {
    return Mechanism(read(flexible_pendulum, overrides).description).sizes().n_flx;
  };
  // The pivot turns freely about its axis and the tip carries a ball joint and a force: 5 + 6 loads.
  EXPECT_EQ(modes_of({"body.beam.modes=4"}), 4);
  EXPECT_EQ(modes_of({"body.beam.modes=4", "body.beam.attachments=used"}), 4 + 5 + 6);
  EXPECT_EQ(modes_of({"body.beam.modes=4", "body.beam.attachments=all"}), 4 + 12);
  EXPECT_EQ(modes_of({"body.beam.fidelity=static"}), 5 + 6);
  EXPECT_EQ(modes_of({"body.beam.frame=joint_fixed"}), 18);
  EXPECT_EQ(modes_of({"body.beam.coupling=partial"}), 18);
  const MechanismFile held = read(
      flexible_pendulum, {"body.beam.frame=joint_fixed", "body.beam.modes=4", "body.beam.attachments=used"});
  EXPECT_THAT(held.notes[0],
              HasSubstr("joint \"pivot\" on interface \"left\" gives the frame and the eigenmodes'"));
  EXPECT_THAT(held.notes[1], HasSubstr("and 11 response modes up to"));
  // Response modes above the eigenmodes follow their loads: critical damping, d = 2 omega.
  const auto& data = held.description.bodies[1].flexible->data();
  EXPECT_DOUBLE_EQ(data.damping(data.damping.size() - 1),
                   2.0 * std::sqrt(data.stiffness(data.stiffness.size() - 1)));
  EXPECT_LT(data.damping(0), std::sqrt(data.stiffness(0)));

  for (const char* fidelity : {"ked", "static", "modal"}) {
    SCOPED_TRACE(fidelity);
    all_identities_hold(Mechanism(read(flexible_pendulum, {std::string("body.beam.fidelity=") + fidelity,
                                                           "body.beam.frame=joint_fixed"})
                                      .description),
                        5);
  }
  const Mechanism ked(read(flexible_pendulum, {"body.beam.fidelity=ked"}).description);
  EXPECT_EQ(ked.sizes().n_flx, 0);
  EXPECT_EQ(ked.sizes().n_dyn, 2 * 18);

  const auto refusal_of = [&](const std::vector<std::string>& overrides) -> std::string {
    try {
      read(flexible_pendulum, overrides);
    } catch (const input::InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal_of({"body.beam.fidelity=modal-stiffened"}),
              HasSubstr("has no geometric stiffening terms; reduce the part again"));
  EXPECT_THAT(refusal_of({"body.beam.damping=0.1", "body.beam.rayleigh_beta=1e-4"}),
              HasSubstr("has more than one damping law"));
  EXPECT_THAT(refusal_of({"body.beam.damping_ratios=[0.1]"}), HasSubstr("make a table together"));
  EXPECT_THAT(refusal_of({"body.beam.fidelity=static", "body.beam.modes=3"}),
              HasSubstr("takes no eigenmodes"));
}

TEST_F(MechanismFileTest, ConstraintsSatisfyAllIdentities) {
  const std::string frame = R"toml(
[ground.marker.track]
position = [0.1, 0.2, -0.4]
axis = [0.1, 0.2, 1]
[body.a]
mass = 1
inertia = [1, 2, 2.5]
center = [0.1, 0, 0.2]
[body.a.marker.out]
position = [0.3, 0.1, 0.2]
rotation = [0.3, 0.4, 0.5]
[body.b]
mass = 2
inertia = [1, 2, 2.5]
[body.b.marker.in]
position = [0.1, 0.5, -0.2]
axis = [1, 2, 3]
[body.c]
mass = 1
[joint.first]
type = "six_dof"
from = "ground"
to = "a"
[joint.second]
type = "cylindrical"
from = "a.out"
to = "b"
[joint.third]
type = "prismatic"
from = "ground.track"
to = "c"
[constraint.c]
)toml";
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
              HasSubstr("has a negative principal moment"));
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

}  // namespace
}  // namespace flexura::mbs
