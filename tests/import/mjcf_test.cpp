// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <numbers>

#include "import/mjcf/convert.hpp"
#include "import/model/folder.hpp"
#include "mbs/file/read_mechanism.hpp"
#include "mbs/library/simulation.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

class Mjcf : public testing::Test {
 protected:
  import::Mechanism read(const std::string& inside) {
    const auto file = folder_.write("m.xml", "<mujoco>" + inside + "</mujoco>");
  import::Findings findings(file);
  import::Mechanism m = import::mjcf::to_mechanism(file, {}, findings);
  import::tell(findings, m);
  return m;
}
/// All faults, one a line.
std::string
faults(const std::string& inside) {
  try {
    read(inside);
  } catch (const import::Faults& all) {
    std::string out = all.what();
    for (const std::string& fault : all.all()) out += "\n" + fault;
    return out;
  } catch (const std::invalid_argument& why) {
    return why.what();
  }
  return "";
}
mbs::Simulation run(const std::string& inside, std::vector<std::string> set = {}) {
  const std::string name = fmt::format("out{}", ++n_);
  import::write_folder(folder_ / name, read(inside), {}, false);
  return mbs::Simulation(mbs::Mechanism(
      mbs::read_mechanism(folder_ / name / "mechanism.toml", mbs::solver_schema(), set).description));
}
static std::string notes(const import::Mechanism& m) {
  std::string out;
  for (const std::string& note : m.notes) out += note + "\n";
  return out;
}

Folder folder_;
int n_ = 0;
};  // namespace

// Euler's equations: I alpha = tau - w x I w, with the armature a on the diagonal of I alone, a damper d and a spring k towards the start.
TEST_F(Mjcf, BallJointsHaveArmatureSpringAndDamper) {
  const auto s =
      run("<option gravity='0 0 0'/><worldbody><body><joint name='j' type='ball' armature='0.5' "
          "damping='0.3' stiffness='2'/>"
          "<inertial pos='0 0 0' mass='1' diaginertia='0.1 0.2 0.25'/></body></worldbody>",
          {"joint.j.omega_x=1", "joint.j.omega_y=2", "joint.j.omega_z=3"});
  const Eigen::Vector3d w(1, 2, 3), I(0.1, 0.2, 0.25);
  const Eigen::Vector3d torque = -0.3 * w - w.cross(I.cwiseProduct(w));
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(s.output(std::string("j.alpha_") + "xyz"[k]), torque[k] / (I[k] + 0.5), 1e-12);
}

TEST_F(Mjcf, FreeBodiesStandWhereTheFilePutsThemAndFall) {
  const auto s =
      run("<compiler angle='radian'/><worldbody><body pos='1 2 3' euler='0 0 0.5'><freejoint name='f'/><geom "
          "size='.1'/></body></worldbody>");
  EXPECT_NEAR(s.output("f.x"), 1.0, 1e-15);
  EXPECT_NEAR(s.output("f.qz"), std::sin(0.25), 1e-15);
  EXPECT_NEAR(s.output("f.a_z"), -9.81, 1e-12);
}

TEST_F(Mjcf, GravityCompensationHoldsItsShare) {
  const auto s =
      run("<worldbody><body gravcomp='0.75'><joint name='j' type='slide'/><geom size='.1' pos='.2 0 "
          "0'/></body></worldbody>");
  EXPECT_NEAR(s.output("j.acceleration"), -0.25 * 9.81, 1e-12);
}

// A body of 2 kg between two springs along a line: the tendon is their path, with a stiffness of 10 N/m beyond 1 m.
TEST_F(Mjcf, SpatialTendonsPullAlongTheirPath) {
  const auto s =
      run("<option gravity='0 0 0'/><worldbody><site name='a' pos='0 0 2'/><body><joint name='j' "
          "type='slide'/><site name='b'/>"
          "<inertial pos='0 0 0' mass='2' diaginertia='1 1 1'/></body></worldbody>"
          "<tendon><spatial name='t' stiffness='10' damping='3' springlength='1'><site site='a'/><site "
          "site='b'/></spatial></tendon>",
          {"joint.j.speed=0.5"});
  EXPECT_NEAR(s.output("j.acceleration"), (10.0 * 1.0 - 3.0 * 0.5) / 2.0, 1e-12);
}

TEST_F(Mjcf, TendonArmatureIsInertiaAlongItsLength) {
  const auto s =
      run("<worldbody><site name='a' pos='0 0 2'/><body><joint name='j' type='slide'/><site name='b'/>"
          "<inertial pos='0 0 0' mass='2' diaginertia='1 1 1'/></body></worldbody>"
          "<tendon><spatial name='t' armature='3'><site site='a'/><site site='b'/></spatial></tendon>");
  EXPECT_NEAR(s.output("j.acceleration"), -2.0 * 9.81 / 5.0, 1e-12);
}

TEST_F(Mjcf, EqualitiesHold) {
  const std::string two =
      "<worldbody><body name='a'><joint name='x' type='slide'/><inertial pos='0 0 0' mass='2' diaginertia='1 "
      "1 1'/></body>"
      "<body name='b' pos='1 0 0'><joint name='y' type='slide'/><inertial pos='0 0 0' mass='3' "
      "diaginertia='1 1 1'/></body></worldbody>";
  // y = 2 x: (2 + 4 3) x'' = -(2 + 2 3) g
  const auto gear = run(two + "<equality><joint joint1='y' joint2='x' polycoef='0 2 0 0 0'/></equality>");
  EXPECT_NEAR(gear.output("x.acceleration"), -9.81 * 8.0 / 14.0, 1e-12);
  EXPECT_NEAR(gear.output("y.acceleration"), -9.81 * 16.0 / 14.0, 1e-12);
  const auto held = run(two + "<equality><weld body1='a'/></equality>");
  EXPECT_NEAR(held.output("x.acceleration"), 0.0, 1e-10);
  EXPECT_NEAR(held.output("y.acceleration"), -9.81, 1e-12);
}

// A ball of radius r in a fluid of viscosity eta and density rho: b = 2 r sqrt(3/5) is the edge of the box with its inertia.
TEST_F(Mjcf, FluidDragsTheInertiaBox) {
  const double r = 0.1, v = 2.0, eta = 0.7, rho = 50.0, m = 4.0 / 3.0 * std::numbers::pi * r * r * r * 1000.0;
  const double b = std::sqrt(6.0 * 0.4) * r;
  const auto s =
      run("<option density='50' viscosity='0.7' gravity='0 0 0'/><worldbody><body><joint name='j' "
          "type='slide'/><geom size='.1'/></body></worldbody>",
          {"joint.j.speed=2"});
  EXPECT_NEAR(s.output("j.acceleration"),
              -(3.0 * std::numbers::pi * b * eta * v + 0.5 * rho * b * b * v * v) / m, 1e-10);
}

TEST_F(Mjcf, ReplicasStandOneBehindTheOther) {
  const auto m = read(
      "<worldbody><replicate count='3' offset='0 0 1' euler='0 0 90' sep='_'><body name='a' pos='1 0 "
      "0'><joint name='j'/><geom size='.1'/></body></replicate></worldbody>"
      "<actuator><motor joint='j'/></actuator>");
  ASSERT_EQ(m.bodies.size(), 3U);
  EXPECT_EQ(m.bodies[2].name, "a_2");
  const Eigen::Vector3d at = m.ground[2].X_BM.p;  // turned by 180 deg, 2 m up
  EXPECT_NEAR((at - Eigen::Vector3d(-1, 0, 2)).norm(), 0.0, 1e-12);
  EXPECT_EQ(std::ranges::count(m.elements, "input", &import::Element::table), 3);
}

TEST_F(Mjcf, KeyframesAreStates) {
  const std::string text = import::mechanism_text(
      read("<worldbody><body><joint name='j'/><geom size='.1' pos='1 0 0'/></body></worldbody><keyframe><key "
           "name='up' qpos='0.5' qvel='2'/></keyframe>"));
  EXPECT_THAT(text, HasSubstr("[state.up]\nvalues = { \"j.angle\" = 0.5, \"j.speed\" = 2.0 }"));
}

TEST_F(Mjcf, SettotalmassScalesAll) {
  const auto m = read(
      "<compiler settotalmass='5'/><worldbody><body><joint/><geom size='.1' pos='1 0 0'/><body pos='1 0 "
      "0'><joint/><geom type='box' size='.1 .2 .3'/></body></body></worldbody>");
  EXPECT_NEAR(m.bodies[0].mass + m.bodies[1].mass, 5.0, 1e-12);
}

TEST_F(Mjcf, TellsAllFaultsAtOnce) {
  const std::string all = faults(
      "<default><joint damping='nan'/></default><worldbody><body><joint axis='0 0 0'/><geom "
      "size='-1'/></body>\n"
      "<body><joint type='hing'/></body><body><joint/><geom type='mesh' mesh='lost'/></body>\n"
      "<flexcomp name='cloth' type='grid'/><body><joint class='none'/></body></worldbody><actuator><motor "
      "joint='lost'/></actuator>");
  for (const char* what : {"axis of <joint> has no length", "\"hing\"", "there is no <mesh> \"lost\"",
                           "<flexcomp> (\"cloth\"", "\"none\""})
    EXPECT_THAT(all, HasSubstr(what));
}

TEST_F(Mjcf, NamesJointsThatMoveNothing) {
  EXPECT_THAT(faults("<worldbody><body><joint name='j'/></body></worldbody>"),
              HasSubstr("joint \"j\" moves bodies without inertia"));
  EXPECT_THAT(faults("<worldbody><body><joint/><geom size='1' pos='1 0 "
                     "0'/></body></worldbody><actuator><motor joint='lost'/></actuator>"),
              HasSubstr("<motor> names \"lost\", which the file does not have"));
}

TEST_F(Mjcf, SaysWhatItLeavesOut) {
  const std::string told = notes(
      read("<include file='lost.xml'/><worldbody><camera/><body><joint name='j'/><geom size='.1' pos='1 0 "
           "0'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 5'/></body></worldbody>"
           "<actuator><muscle joint='j'/></actuator>"));
  for (const char* what : {"\"lost.xml\" that it includes is not there", "contact of 1 geoms", "1 camera",
                           "are those of no body; taken are"})
    EXPECT_THAT(told, HasSubstr(what));
}

TEST_F(Mjcf, RefusesFilesThatIncludeThemselves) {
  folder_.write("a.xml", "<mujoco><include file='b.xml'/></mujoco>");
  folder_.write("b.xml", "<mujoco><include file='a.xml'/></mujoco>");
  EXPECT_THAT(faults("<include file='a.xml'/><worldbody><body><geom size='1'/></body></worldbody>"),
              HasSubstr("includes itself"));
}

}  // namespace flexura::test
}  // namespace flexura::test
