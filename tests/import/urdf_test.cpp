// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What the kinds of joints, limits, mimic, friction, transmissions and pictures of a URDF become.
#include <gmock/gmock.h>

#include <cstring>
#include <fstream>

#include "mbs/superelement/file.hpp"
#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

TEST(UrdfImport, FloatingBallFallsFreely) {
  const Folder folder;
  const results::Run run =
      run_robot(folder, sample("gripper.urdf"), {"--end-time", "0.3", "--set", "solver.tolerance=1e-9"});
  const auto& ball = body(run, "ball");
  for (Eigen::Index row = 0; row < run.time.size(); ++row) {
    const double t = run.time[row];
    EXPECT_NEAR(ball.pose(row, 2), 2.0 - 0.5 * 9.81 * t * t, 1e-8);  // the integrator's tolerance times 10
    EXPECT_NEAR(ball.pose(row, 0), 1.0, 1e-12);
  }
}

TEST(UrdfImport, MimickingFingerFollowsAndAMotorTurnsBoth) {
  const Folder folder;
  const results::Run run =
      run_robot(folder, sample("gripper.urdf"),
                {"--end-time", "0.02", "--set", "solver.output_step=0.002", "input.u_motor_1.value=0.001",
                 "joint.on_table.drive_x=0", "joint.on_table.drive_y=0", "joint.on_table.drive_angle=0",
                 "output.quantities=[\"*\"]"});
  const Eigen::VectorXd left = column(run, "left_finger.angle"), right = column(run, "right_finger.angle");
  for (Eigen::Index row = 0; row < left.size(); ++row) EXPECT_NEAR(right[row], -1.25 * left[row] + 0.1, 1e-9);
  // Both fingers turn about their own axes, 1.3e-4 kg m^2 each; 50 times 0.001 N m of the motor.
  const double inertia = (4e-5 + 0.1 * 0.03 * 0.03) * (1.0 + 1.25 * 1.25);
  EXPECT_NEAR(column(run, "left_finger.acceleration")[0], 0.05 / inertia, 1e-6 * 0.05 / inertia);
}

TEST(UrdfImport, LiftCarriesItsLoadAgainstDampingAndFriction) {
  const Folder folder;
  const results::Run run =
      run_robot(folder, sample("gripper.urdf"),
                {"--end-time", "0.1", "--set", "joint.lift.drive_speed=0.05", "output.quantities=[\"*\"]"});
  // 0.7 kg hang on it; at fifty transition speeds the friction has its full 2 N.
  const Eigen::VectorXd force = column(run, "lift.drive_force");
  EXPECT_NEAR(force[force.size() - 1], 0.7 * 9.81 + 2.0 + 3.0 * 0.05, 1e-3);
}

TEST(UrdfImport, StopEndsTheTravel) {
  const Folder folder;
  const results::Run run = run_robot(folder, sample("gripper.urdf"),
                                     {"--end-time", "2", "--set", "output.quantities=[\"lift.*\"]"});
  // The lift rests on its lower stop: 0.1 m less the weight over the stiffness, at most 1 % of 0.3 m.
  const Eigen::VectorXd z = column(run, "lift.position");
  EXPECT_GT(z.minCoeff(), 0.1 - 0.003);
  EXPECT_LT(z[z.size() - 1], 0.1);
  const Folder without;
  const results::Run free =
      run_robot(without, sample("gripper.urdf"),
                {"--end-time", "1", "--set", "output.quantities=[\"lift.*\"]"}, {"--no-stops"});
  EXPECT_LT(column(free, "lift.position").minCoeff(), -1.0);
}

TEST(UrdfImport, FloatingBaseFallsWithTheRobot) {
  const Folder folder;
  const auto urdf = folder.write("rod.urdf", R"(<robot name="rod"><link name="rod"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1"/></inertial></link></robot>)");
  const results::Run run = run_robot(folder, urdf, {"--end-time", "0.5"}, {"--base", "floating"});
  EXPECT_NEAR(body(run, "rod").pose(run.time.size() - 1, 2), -0.5 * 9.81 * 0.25, 1e-6);
}

// A rod hung by its end on a ball, held out along x: it falls about y like a hinged one, q'' = m g l / (I + m l^2).
TEST(UrdfImport, BallJointsTurnAboutAllAxes) {
  const Folder folder;
  const auto file = folder.write(
      "r.urdf",
      robot(
          link("a") +
          link(
              "b",
              R"(<inertial><origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.01" iyy="0.2" izz="0.2" ixy="0" ixz="0" iyz="0"/></inertial>)") +
          joint("j", "ball", "a", "b")));
  const results::Run run =
      run_robot(folder, file, {"--end-time", "0.01", "--set", "output.quantities=[\"j.*\"]"});
  EXPECT_NEAR(column(run, "j.alpha_y")[0], 2.0 * 9.81 * 0.5 / (0.2 + 2.0 * 0.25), 1e-9);
  EXPECT_NEAR(column(run, "j.alpha_x")[0], 0.0, 1e-12);
}

TEST(UrdfImport, MeshesAndTurnedBoxesBecomeRigidSuperelementsOfTheSameInertia) {
  const Folder folder;
  // A tetrahedron as text and as binary STL and as OBJ.
  folder.write(
      "t.stl",
      "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 1\nvertex 1 0 0\nendloop\nendfacet\nendsolid "
      "t\n");
  folder.write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf -1// -2// -3//\n");
  std::string binary(84, ' ');
  const std::uint32_t n = 1;
  const float triangle[12] = {0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 3, 0};
  std::memcpy(binary.data() + 80, &n, 4);
  binary.append(reinterpret_cast<const char*>(triangle), 48).append(2, '\0');
  folder.write("b.stl", binary);
  const auto urdf = folder.write("r.urdf", R"(<robot name="r"><link name="a">
    <inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/><inertia ixx="0.3" iyy="0.4" izz="0.5" ixy="0.01" ixz="0.02" iyz="-0.03"/></inertial>
    <visual><geometry><mesh filename="t.stl" scale="0.1 0.1 0.1"/></geometry></visual>
    <visual><geometry><mesh filename="t.obj"/></geometry></visual>
    <visual><origin xyz="0 0 1"/><geometry><mesh filename="b.stl"/></geometry></visual>
    <visual><origin rpy="0 0 0.5"/><geometry><box size="1 2 3"/></geometry></visual>
    <visual><geometry><mesh filename="package://elsewhere/lost.dae"/></geometry></visual></link></robot>)");
  const Outcome imported = run("flexura", {"import", urdf, "-o", folder / "out"});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_THAT(
      imported.err,
      HasSubstr("link \"a\" without that picture: mesh \"package://elsewhere/lost.dae\" is not there"));
  const auto se = superelement::read(folder / "out/parts/a.se.h5", {.surface = true});
  EXPECT_EQ(se.surface.triangles.rows(), 2 + 2 + 1 + 12);
  EXPECT_NEAR(se.surface.vertices.col(1).maxCoeff(), 3.0, 1e-15);
  EXPECT_DOUBLE_EQ(se.inertia.mass, 2.0);
  // About the centre of mass: tr(S) 1 - S with S shifted by Steiner.
  const Eigen::Vector3d c = se.inertia.S_x / 2.0;
  EXPECT_NEAR((c - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 0.0, 1e-15);
  const Eigen::Matrix3d S = se.inertia.S_xx - 2.0 * c * c.transpose();
  Eigen::Matrix3d I;
  I << 0.3, 0.01, 0.02, 0.01, 0.4, -0.03, 0.02, -0.03, 0.5;
  EXPECT_LT((S.trace() * Eigen::Matrix3d::Identity() - S - I).norm(), 1e-15);
  // It is drawn from wherever the results lie, and a body that cannot deform leaves no error to be estimated.
  const Outcome simulated = run(
      "flexura", {"simulate", folder / "out/mechanism.toml", "-o", folder / "r.h5", "--end-time", "0.01"});
  EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
  EXPECT_THAT(simulated.out, Not(HasSubstr("stiffening")));
  EXPECT_EQ(run("flexura", {"view", folder / "r.h5", "-o", folder / "r.html"}).exit_code, 0);
}

}  // namespace
}  // namespace flexura::test
