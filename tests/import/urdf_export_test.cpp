// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Mechanisms written as URDF and read back: the same motion needs the same torques.
#include <gmock/gmock.h>
#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

// A swinging arm whose bodies' frames are nowhere near their joints: a hinge written backwards (the body is "from"), a cylindrical, a
// planar and a universal joint, gravity along -z.
const char* const kArm = R"(
name = "odd arm"
[ground.marker.base]
position = [0.1, 0.2, 0.3]
axis = [1, 1, 0]
[body.upper]
mass = 2
center = [0.2, 0.01, -0.02]
inertia = [0.02, 0.03, 0.04, 0.001, -0.002, 0.003]
[body.upper.marker.root]
position = [-0.1, 0.02, 0.03]
quaternion = [0.9, 0.1, -0.2, 0.3]
[body.upper.marker.end]
position = [0.5, 0.0, 0.1]
axis = [0, 1, 0.3]
[body.lower]
mass = 1.5
center = [0.1, -0.03, 0.02]
inertia = [0.005, 0.02, 0.02]
[body.lower.marker.root]
position = [0.02, 0.01, 0]
axis = [0.2, 0, 1]
[body.lower.marker.end]
position = [0.3, 0, 0]
[body.plate]
mass = 0.7
inertia = [0.004, 0.003, 0.005]
[body.plate.marker.under]
position = [0, 0.05, -0.01]
[body.plate.marker.cross]
position = [0.1, 0, 0]
[[body.plate.shape]]
type = "box"
center = [0, 0, 0]
size = [0.2, 0.1, 0.02]
[body.tool]
mass = 0.4
center = [0, 0, 0.05]
inertia = [0.001, 0.0011, 0.0005]
[body.tool.marker.cross]
[joint.hip]
type = "revolute"
from = "upper.root"
to = "ground.base"
[joint.knee]
type = "cylindrical"
from = "upper.end"
to = "lower.root"
[joint.table]
type = "planar"
from = "lower.end"
to = "plate.under"
[joint.cross]
type = "universal"
from = "plate.cross"
to = "tool.cross"
)";

// Coordinates of the file's joints and of those they become, with the sign that a joint written backwards gets.
struct Driven {
  const char *joint, *key;      // "joint.JOINT.KEY" of the mechanism file
  const char *written, *force;  // the joint of the URDF, the quantity that the first has
};
const Driven kDriven[] = {{"hip", "drive", "hip", "hip.drive_force"},
                          {"knee", "drive_angle", "knee_angle", "knee.drive_force_angle"},
                          {"knee", "drive_position", "knee_position", "knee.drive_force_position"},
                          {"table", "drive_x", "table_x", "table.drive_force_x"},
                          {"table", "drive_y", "table_y", "table.drive_force_y"},
                          {"table", "drive_angle", "table_angle", "table.drive_force_angle"},
                          {"cross", "drive_angle_1", "cross_angle_1", "cross.drive_force_angle_1"},
                          {"cross", "drive_angle_2", "cross_angle_2", "cross.drive_force_angle_2"}};

std::string motion(int i) {
  return fmt::format("{}*sin({}*t+{})", i == 2 || i == 3 || i == 4 ? 0.05 : 0.6 + 0.1 * i, 1.3 + 0.4 * i,
                     0.2 * i);
}

results::Run driven(const Folder& folder, const std::string& mechanism,
                    const std::vector<std::string>& drives) {
  std::vector<std::string> words = {"simulate",
                                    mechanism,
                                    "-o",
                                    folder / "r.h5",
                                    "--no-estimate",
                                    "--set",
                                    "solver.method=kinematics",
                                    "solver.end_time=1",
                                    "solver.output_step=0.1",
                                    "output.quantities=[\"*\"]"};
  words.insert(words.end(), drives.begin(), drives.end());
  const Outcome o = run("flexura", words);
  EXPECT_EQ(o.exit_code, 0) << o.err;
  return results::read(folder / "r.h5").runs.at(0);
}

TEST(UrdfExport, TheSameMotionNeedsTheSameForces) {
  const Folder folder;
  const auto file = folder.write("arm.toml", kArm);
  const Outcome exported = run("flexura", {"export", file, "--format", "urdf", "-o", folder / "arm.urdf"});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  ASSERT_TRUE(urdf::parseURDF(read_text(folder / "arm.urdf"))) << read_text(folder / "arm.urdf");
  const Outcome imported =
      run("flexura", {"import", folder / "arm.urdf", "-o", folder / "again", "--no-stops"});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  std::vector<std::string> first, second;
  for (int i = 0; i < 8; ++i) {
    first.push_back(fmt::format("joint.{}.{}={}", kDriven[i].joint, kDriven[i].key, motion(i)));
    second.push_back(fmt::format("joint.{}.drive={}", kDriven[i].written, motion(i)));
  }
  const results::Run a = driven(folder, file, first),
                     b = driven(folder, folder / "again/mechanism.toml", second);
  ASSERT_EQ(a.time.size(), b.time.size());
  double largest = 0.0;
  for (const Driven& d : kDriven) largest = std::max(largest, column(a, d.force).cwiseAbs().maxCoeff());
  // Numbers are written with all their digits; the drives' forces solve a system of condition 1e4 or less.
  for (const Driven& d : kDriven)
    EXPECT_LT(
        (column(a, d.force) - column(b, fmt::format("{}.drive_force", d.written))).cwiseAbs().maxCoeff(),
        1e-9 * largest)
        << d.written;
  // The link of a body stands at the joint that leads to it, turned by the same turn at all times.
  const auto& tool = body(a, "tool").pose;
  const auto& link = body(b, "tool").pose;
  EXPECT_LT((tool.leftCols(3) - link.leftCols(3)).norm(), 1e-12);
  const auto turn = [](const auto& row) { return Eigen::Quaterniond(row[3], row[4], row[5], row[6]); };
  const Eigen::Quaterniond start = turn(tool.row(0)).conjugate() * turn(link.row(0));
  for (Eigen::Index row = 0; row < a.time.size(); ++row)
    EXPECT_LT((turn(tool.row(row)).conjugate() * turn(link.row(row))).angularDistance(start), 1e-7);
}

TEST(UrdfExport, AnImportedRobotComesBackWithItsLinksAndMasses) {
  const Folder folder;
  ASSERT_EQ(run("flexura", {"import", sample("arm.urdf"), "-o", folder / "arm"}).exit_code, 0);
  const Outcome o = run(
      "flexura", {"export", folder / "arm/mechanism.toml", "--format", "urdf", "-o", folder / "back.urdf"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  // What stands for something that a URDF has no word for is said.
  EXPECT_THAT(o.err, HasSubstr("a URDF has no stiffness of limits"));
  const auto before = urdf::parseURDF(read_text(sample("arm.urdf"))),
             after = urdf::parseURDF(read_text(folder / "back.urdf"));
  ASSERT_TRUE(after);
  for (const char* const name : {"shoulder", "forearm", "wrist_1", "slide", "flange"}) {
    const auto &i = before->getLink(name)->inertial, &j = after->getLink(name)->inertial;
    ASSERT_TRUE(j) << name;
    EXPECT_DOUBLE_EQ(i->mass, j->mass);
    // Frames are turned, the trace is not; the file's inertia is about the centre of mass as ours.
    EXPECT_NEAR(i->ixx + i->iyy + i->izz, j->ixx + j->iyy + j->izz, 1e-14);
  }
  EXPECT_EQ(after->getJoint("j6")->type, urdf::Joint::PRISMATIC);
  // The upper arm's box is turned in its link: a mesh.
  EXPECT_TRUE(std::filesystem::exists(folder / "back_meshes/upper_arm.stl"));
}

// Limits, damping, friction and mimicking as another reader of URDF sees them, before and after.
TEST(UrdfExport, LimitsDampingFrictionAndMimicComeBack) {
  for (const std::string robot : {"arm.urdf", "gripper.urdf"}) {
    const Folder folder;
    ASSERT_EQ(run("flexura", {"import", sample(robot), "-o", folder / "in"}).exit_code, 0);
    const Outcome o = run(
        "flexura", {"export", folder / "in/mechanism.toml", "--format", "urdf", "-o", folder / "back.urdf"});
    ASSERT_EQ(o.exit_code, 0) << o.err;
    const auto before = urdf::parseURDF(read_text(sample(robot))),
               after = urdf::parseURDF(read_text(folder / "back.urdf"));
    ASSERT_TRUE(after) << robot;
    int limits = 0, dynamics = 0, mimics = 0;
    for (const auto& [name, old] : before->joints_) {
      std::string written = name;
      std::ranges::replace(written, ' ', '_');
      const auto now = after->getJoint(written);
      if (old->type == urdf::Joint::PLANAR) continue;  // a chain of three
      ASSERT_TRUE(now) << written;
      // A joint that mimics is held by the other: without stops of its own it is continuous.
      if (!old->mimic) EXPECT_EQ(old->type, now->type) << written;
      if (old->limits && old->type != urdf::Joint::CONTINUOUS && !old->mimic) {
        ++limits;
        EXPECT_DOUBLE_EQ(old->limits->lower, now->limits->lower) << written;
        EXPECT_DOUBLE_EQ(old->limits->upper, now->limits->upper) << written;
        EXPECT_GE(now->limits->effort, old->limits->effort * (1.0 - 1e-12)) << written;
      }
      if (old->dynamics) {
        ++dynamics;
        ASSERT_TRUE(now->dynamics) << written;
        EXPECT_DOUBLE_EQ(old->dynamics->damping, now->dynamics->damping) << written;
        EXPECT_DOUBLE_EQ(old->dynamics->friction, now->dynamics->friction) << written;
      }
      if (old->mimic) {
        ++mimics;
        ASSERT_TRUE(now->mimic) << written;
        EXPECT_DOUBLE_EQ(old->mimic->multiplier, now->mimic->multiplier);
        EXPECT_DOUBLE_EQ(old->mimic->offset, now->mimic->offset);
      }
    }
    EXPECT_GT(limits + dynamics + mimics, 3) << robot;
    // What is imported again moves as the first: it falls on its stops, damped.
    ASSERT_EQ(run("flexura", {"import", folder / "back.urdf", "-o", folder / "again"}).exit_code, 0);
    std::vector<results::Run> runs;
    for (const char* const which : {"in", "again"}) {
      const Outcome ran = run("flexura", {"simulate", folder / (std::string(which) + "/mechanism.toml"), "-o",
                                          folder / "r.h5", "--no-estimate", "--end-time", "0.3", "--set",
                                          "solver.tolerance=1e-9", "output.quantities=[\"*\"]"});
      ASSERT_EQ(ran.exit_code, 0) << ran.err;
      runs.push_back(results::read(folder / "r.h5").runs.at(0));
    }
    // Within the integrator's tolerance; the links' frames are turned about their axes.
    const std::string last = robot == "arm.urdf" ? "flange" : "left";
    EXPECT_LT(
        (body(runs[0], last).pose.leftCols(3) - body(runs[1], last).pose.leftCols(3)).cwiseAbs().maxCoeff(),
        1e-6)
        << robot;
  }
}

TEST(UrdfExport, WhatHasNoWordIsNamedAndNotWritten) {
  const Folder folder;
  const auto file = folder.write("arm.toml", std::string(kArm) + R"(
[force.hinge_spring]
type = "joint_spring_damper"
joint = "hip"
stiffness = 3
[force.one_end]
type = "bump_stop"
joint = "cross"
coordinate = "angle_2"
upper = 0.5
stiffness = 100
[constraint.geared]
type = "coupler"
joints = ["knee.position", "hip"]
factors = [2.0, -0.1]
offset = 0.4
)");
  const Outcome o = run("flexura", {"export", file, "--format", "urdf", "-o", folder / "arm.urdf"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.err, HasSubstr("hinge_spring: a URDF has no word for these forces"));
  const auto urdf = urdf::parseURDF(read_text(folder / "arm.urdf"));
  ASSERT_TRUE(urdf);
  EXPECT_FALSE(urdf->getJoint("hip")->dynamics);
  EXPECT_EQ(urdf->getJoint("cross_angle_2")->type, urdf::Joint::REVOLUTE);
  EXPECT_DOUBLE_EQ(urdf->getJoint("cross_angle_2")->limits->upper, 0.5);
  // 2 z - 0.1 q = 0.4
  ASSERT_TRUE(urdf->getJoint("knee_position")->mimic);
  EXPECT_EQ(urdf->getJoint("knee_position")->mimic->joint_name, "hip");
  EXPECT_DOUBLE_EQ(urdf->getJoint("knee_position")->mimic->multiplier, 0.05);
  EXPECT_DOUBLE_EQ(urdf->getJoint("knee_position")->mimic->offset, 0.2);
}

struct Refusal {
  std::string name, more, says;
};
class UrdfExportRefuses : public testing::TestWithParam<Refusal> {};

TEST_P(UrdfExportRefuses, WhatIsNoTreeOfTurnsAndSlides) {
  const Folder folder;
  const auto file = folder.write("arm.toml", kArm + GetParam().more);
  const Outcome o = run("flexura", {"export", file, "--format", "urdf", "-o", folder / "arm.urdf"});
  EXPECT_EQ(o.exit_code, 2) << o.err;
  EXPECT_THAT(o.err, HasSubstr(GetParam().says));
  EXPECT_FALSE(std::filesystem::exists(folder / "arm.urdf"));
}

INSTANTIATE_TEST_SUITE_P(
    All, UrdfExportRefuses,
    testing::Values(
        Refusal{"loop",
                "[joint.closing]\ntype = \"spherical\"\nfrom = \"ground.base\"\nto = \"tool.cross\"\n",
                "closes a loop"},
        Refusal{"constraint",
                "[constraint.gear]\ntype = \"coupler\"\njoints = [\"hip\", \"hip\"]\nfactors = [1.0, 1.0]\n",
                "constraint \"gear\""},
        Refusal{"moved_gear",
                "[constraint.gear]\ntype = \"coupler\"\njoints = [\"hip\", \"knee.angle\"]\nfactors = [1.0, "
                "1.0]\n"
                "offset = \"0.1*sin(t)\"\n",
                "a URDF has joints only, and one that mimics another"},
        Refusal{"ball",
                "[body.ball]\nmass = 1\ninertia = [1, 1, 1]\n[body.ball.marker.m]\n[joint.ball]\ntype = "
                "\"spherical\"\nfrom = \"ground.base\"\nto = \"ball.m\"\n",
                "joint \"ball\" (spherical)"}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace flexura::test
