// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Collision shapes as contacts with the floor.
#include <gmock/gmock.h>

#include "import/urdf/contacts.hpp"
#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

std::string heavy(const std::string& name, const std::string& geometry, const std::string& origin = "") {
  return link(name, kMass + "<collision>" + origin + "<geometry>" + geometry + "</geometry></collision>");
}

// A ball that is pushed along the floor slides by Gazebo's friction, and is pressed in by its weight over kp.
TEST(UrdfContacts, BallSlidesWithGazebosNumbers) {
  const Folder folder;
  const auto file = folder.write(
      "r.urdf",
      robot(
          link("world", "") + heavy("b", R"(<sphere radius="0.1"/>)") +
          R"(<joint name="f" type="prismatic"><parent link="world"/><child link="x"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>)" +
          link("x", "") +
          joint("g", "prismatic", "x", "b", R"(<axis xyz="1 0 0"/><limit lower="-9" upper="9"/>)") +
          R"(<gazebo reference="b"><kp>1e4</kp><kd>200</kd><mu1 value="0.4"/></gazebo>)"));
  const results::Run run = run_robot(
      folder, file, {"--end-time", "2", "--set", "joint.g.drive_speed=0.5", "output.quantities=[\"*\"]"},
      {"--contacts"});
  const Eigen::Index last = run.time.size() - 1;
  // The floor is where the ball stands at the start, 0.1 m below the origin; half a metre a second is 500 transition speeds.
  EXPECT_NEAR(body(run, "b").pose(last, 2), -9.81 / 1e4, 1e-7);
  EXPECT_NEAR(column(run, "g.drive_force")[last], 0.4 * 9.81, 1e-3);
}

TEST(UrdfContacts, ShapesTouchWhereTheyAreLowest) {
  using import::urdf::Shape;
  for (const auto& [shape, lowest] :
       {std::pair(Shape{.kind = Shape::Kind::box, .size = {1, 2, 3}}, -1.5),
        std::pair(Shape{.kind = Shape::Kind::sphere, .radius = 0.2}, -0.2),
        std::pair(Shape{.kind = Shape::Kind::capsule, .radius = 0.2, .length = 1}, -0.7),
        std::pair(Shape{.kind = Shape::Kind::cylinder, .radius = 0.2, .length = 1}, -0.5)}) {
    double z = 0.0;
    for (const import::urdf::Ball& ball : balls_of(shape)) z = std::min(z, ball.center.z() - ball.radius);
    EXPECT_DOUBLE_EQ(z, lowest);
  }
}

TEST(UrdfContacts, WhatStandsMakesNone) {
  const Folder folder;
  const auto file = folder.write(
      "r.urdf", robot(heavy("a", R"(<box size="1 1 1"/>)") + heavy("b", R"(<mesh filename="lost.stl"/>)") +
                      heavy("c", R"(<sphere radius="0.1"/>)") + joint("j", "continuous", "a", "b") +
                      joint("k", "fixed", "a", "c")));
  const Outcome outcome = run("flexura", {"import", file, "-o", folder / "out", "--contacts"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("--contacts makes none"));
  EXPECT_THAT(outcome.err, HasSubstr("link \"b\": 1 collision mesh makes no contact"));
}

}  // namespace
}  // namespace flexura::test
