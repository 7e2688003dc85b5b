// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Links that move and have no inertia.
#include <gmock/gmock.h>

#include <numbers>

#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

const std::string kBall =
    R"(<collision><origin xyz="0.5 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>)";

// A ball of 0.1 m half a metre beside a hinge, its weight pulling it down: q'' = -g r / (r^2 + 2/5 R^2).
TEST(UrdfMassless, TakeTheInertiaOfTheirShapes) {
  const Folder folder;
  const auto file = folder.write(
      "r.urdf",
      robot(link("a") + link("b", kBall) + joint("j", "continuous", "a", "b", "<axis xyz=\"0 1 0\"/>")));
  const results::Run run =
      run_robot(folder, file, {"--end-time", "0.01", "--set", "output.quantities=[\"j.*\"]"},
                {"--density", "2000 kg/m^3"});
  EXPECT_NEAR(column(run, "j.acceleration")[0], 9.81 * 0.5 / (0.25 + 0.4 * 0.01), 1e-9);
  const double mass = 2000.0 * 4.0 / 3.0 * std::numbers::pi * 1e-3;
  EXPECT_THAT(read_text(folder / "robot/mechanism.toml"), HasSubstr(fmt::format("mass = {:.6g}", mass)));
}

// A mass without moments keeps its place; the shape's moments are scaled to it.
TEST(UrdfMassless, MassesWithoutMomentsKeepTheirMass) {
  const Folder folder;
  const auto file = folder.write(
      "r.urdf",
      robot(
          link("a") +
          link(
              "b",
              R"(<inertial><mass value="3"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>)" +
                  kBall) +
          joint("j", "continuous", "a", "b",
                "<axis xyz=\"0 1 0\"/><dynamics friction=\"0\" damping=\"0\"/>")));
  const Outcome outcome = run("flexura", {"import", file, "-o", folder / "out"});
  EXPECT_THAT(outcome.err, HasSubstr("those of its collision shapes with its mass, 3 kg"));
  EXPECT_THAT(read_text(folder / "out/mechanism.toml"), HasSubstr("inertia = [0.012"));  // 2/5 3 kg 0.01 m^2
}

TEST(UrdfMassless, WholeRobotsMoveAsTheirDrivesSay) {
  const Folder folder;
  const auto file = folder.write(
      "r.urdf",
      robot(
          link("a", "") + link("b", "") + link("c", "") +
          joint("j", "revolute", "a", "b",
                R"(<origin xyz="0 0 0.3"/><axis xyz="0 1 0"/><limit lower="-1" upper="1"/>)") +
          joint(
              "k", "prismatic", "b", "c",
              R"(<axis xyz="1 0 0"/><limit lower="0.2" upper="1"/><mimic joint="j" multiplier="0.5" offset="0.4"/>)")));
  const Outcome refused = run("flexura", {"import", file, "-o", folder / "no", "--massless", "refuse"});
  EXPECT_EQ(refused.exit_code, 2);
  const results::Run run =
      run_robot(folder, file,
                {"--end-time", "1", "--set", "joint.j.drive=0.8*t", "output.quantities=[\"j.*\", \"k.*\"]"});
  const auto& pose = body(run, "c").pose;
  for (Eigen::Index row = 0; row < run.time.size(); ++row) {
    const double q = 0.8 * run.time[row], slide = 0.5 * q + 0.4;
    EXPECT_NEAR(pose(row, 0), slide * std::cos(q), 1e-9);
    EXPECT_NEAR(pose(row, 2), 0.3 - slide * std::sin(q), 1e-9);
  }
}

// Only the joint that moves nothing is driven: the others fall as without it.
TEST(UrdfMassless, TheOthersMoveAsTheyWould) {
  const Folder folder;
  const std::string arm =
      R"(<inertial><origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>)";
  const auto file = folder.write(
      "r.urdf", robot(link("a") + link("b", arm) + link("tip", "") +
                      joint("j", "continuous", "a", "b", "<axis xyz=\"0 1 0\"/>") +
                      joint("k", "continuous", "b", "tip", "<origin xyz=\"1 0 0\"/><axis xyz=\"0 1 0\"/>")));
  const results::Run run =
      run_robot(folder, file, {"--end-time", "0.01", "--set", "output.quantities=[\"j.*\"]"});
  EXPECT_NEAR(column(run, "j.acceleration")[0], 2.0 * 9.81 * 0.5 / (0.02 + 2.0 * 0.25), 1e-7);
}

// Two hinges in line and nothing between them: one of them stands, and the body is one pendulum.
TEST(UrdfMassless, OfTwoJointsInLineOneIsFixed) {
  const Folder folder;
  const std::string arm =
      R"(<inertial><origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>)";
  const std::string joints = joint("j", "continuous", "a", "b", "<axis xyz=\"0 1 0\"/>") +
                             joint("k", "continuous", "b", "c", "<axis xyz=\"0 1 0\"/>");
  const auto file = folder.write("r.urdf", robot(link("a") + link("b", "") + link("c", arm) + joints));
  const results::Run run =
      run_robot(folder, file, {"--end-time", "0.01", "--set", "output.quantities=[\"j.*\"]"});
  EXPECT_NEAR(column(run, "j.acceleration")[0], 2.0 * 9.81 * 0.5 / (0.02 + 2.0 * 0.25), 1e-9);
  // A base that floats and has nothing moves with what hangs on it.
  const Folder other;
  const auto floating = other.write("r.urdf", robot(link("a", "") + link("b", "") + link("c", arm) + joints));
  const results::Run fall = run_robot(other, floating, {"--end-time", "0.5"}, {"--base", "floating"});
  EXPECT_NEAR(body(fall, "c").pose(fall.time.size() - 1, 2), -0.5 * 9.81 * 0.25, 1e-6);
}

}  // namespace
}  // namespace flexura::test
