// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A linear system predicts the run: for random rigid mechanisms with drives, couplers, loops, rolling, controls and forces that
// follow inputs, (A, B, C, D, D_1, D_2) says what the nonlinear run does, growth included.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/properties/linear_scenes.hpp"

namespace flexura::properties {
namespace {

using mbs::chance::Chance;

class RigidMaker : public SceneMaker {
 public:
  using SceneMaker::SceneMaker;
  Scene chain();
  Scene rotor();
  Scene disc();
  Scene four_bar();
  Scene gimbal();
};

// A cart with a chain of pendulums that hangs or stands, both of which are equilibria.
Scene RigidMaker::chain() {
  static constexpr const char* kAxes[] = {"[0, 1, 0]", "[1, 0, 0]", "[0.6, 0.8, 0]"};
  head_ = fmt::format("gravity = [0, 0, {}]\n", number(-9.81, 9.81));
  text_ =
      "[ground.marker.o]\naxis = [1, 0, 0]\n[body.b0]\nmass = 1\ninertia = [0.1, 0.1, 0.1]\n"
      "[body.b0.marker.o]\naxis = [1, 0, 0]\n";
  const int links = 1 + chance_.below(3);
  motion("h.position");
  double end = 0.0;
  for (int i = 1; i <= links; ++i) {
    const double length = number(0.3, 1.0);
    const char* axis = chance_.one_of(kAxes);
    const std::string name = fmt::format("b{}", i), before = fmt::format("b{}", i - 1);
    marker("body." + before, "p", end, axis);
    body(name, length);
    marker("body." + name, "o", 0.0, axis);
    end = length;
    joint(fmt::format("r{}", i), "revolute", before + ".p", name + ".o");
    motion(fmt::format("r{}.angle", i));
  }
  const std::string last = fmt::format("r{}", links);
  const bool is_driven = chance_.flip(0.8);
  joint("h", "prismatic", "ground.o", "b0.o", is_driven ? drive("h.position", "h.speed", "r1.angle") : "");
  if (!is_driven) joint_force("fh", "h", feedback("h.position", "h.speed"));
  if (links > 1 && chance_.flip(0.5)) coupler("r1", "r2");
  if (chance_.flip(0.6)) joint_force("t", last, feedback(last + ".angle", last + ".speed"));
  // Held values are no states.
  if (chance_.flip(0.3)) {
    text_ +=
        "[control.held]\ntype = \"relay\"\ninput = \"r1.angle\"\non_above = 10\noff_below = 5\non = 1\n"
        "off = 0\n";
    joint_force("held", "r1", "held");
  }
  further("r1.speed");
  place(fmt::format("b{}.o", links), "[0, 0, 1]");
  load("h", "[0, 0, 1]");
  load("r1", "[1, 0, 0]");
  return done();
}

// A disc off the axis of a shaft that is driven in speed, on springs along two axes that turn with it.
Scene RigidMaker::rotor() {
  const double w = number(2.0, 10.0), k = number(50.0, 200.0), m = number(0.5, 2.0), d_x = number(0.0, 2.0),
               d_y = number(0.0, 2.0), k_y = k * number(0.5, 3.0);
  head_ = "gravity = [0, 0, 0]\n";
  text_ = fmt::format(
      "[body.s]\nmass = 1\ninertia = [0.1, 0.1, 0.1]\n[body.d]\nmass = {}\ninertia = [0.1, 0.1, 0.15]\n"
      "[body.x]\nmass = 0.3\ninertia = [0.01, 0.01, 0.01]\n[body.s.marker.x]\naxis = [1, 0, 0]\n"
      "[body.x.marker.x]\naxis = [1, 0, 0]\n[body.x.marker.y]\naxis = [0, 1, 0]\n[body.d.marker.y]\naxis = "
      "[0, 1, 0]\n[force.kx]\ntype = \"joint_spring_damper\"\njoint = \"x\"\nstiffness = {}\ndamping = {}\n"
      "[force.ky]\ntype = \"joint_spring_damper\"\njoint = \"y\"\nstiffness = {}\ndamping = {}\n",
      m, k, d_x, k_y, d_y);
  joint("x", "prismatic", "s.x", "x.x");
  joint("y", "prismatic", "x.y", "d.y");
  const std::string u = followed();
  joint("r", "revolute", "ground", "s", fmt::format("drive_speed = \"{} + {}\"\n", w, u));
  joint_force("f", "y", input());
  motion("x.position");
  motion("y.position");
  further("r.speed");
  return done();
}

// A disc that rolls straight on; below a critical speed it falls.
Scene RigidMaker::disc() {
  const double v = number(0.3, 3.0), radius = number(0.2, 0.5), m = number(1.0, 3.0), I = number(0.07, 0.1);
  text_ = fmt::format(
      "[ground.marker.o]\n[body.d]\nmass = {}\ninertia = [0.05, {}, 0.05]\nposition = [0, 0, {:.17g}]\n"
      "velocity = [{:.17g}, 0, 0]\nangular_velocity = [0, {:.17g}, 0]\n[body.d.marker.c]\naxis = [0, 1, 0]\n"
      "[constraint.r]\ntype = \"rolling_disc\"\nfrom = \"ground.o\"\nto = \"d.c\"\nradius = {:.17g}\n",
      m, I, radius, v, v / radius, radius);
  text_ += fmt::format("[force.f]\ntype = \"force\"\nmarker = \"d.c\"\ny = \"{}\"\n", input());
  text_ +=
      "[measure.lean]\ntype = \"axis\"\nfrom = \"ground.o\"\nto = \"d.c\"\ndirection = [0, 0, 1]\n"
      "[measure.head]\ntype = \"axis\"\nfrom = \"ground.o\"\nto = \"d.c\"\ndirection = [1, 0, 0]\n";
  motion("lean");
  motion("head");
  place("d.c", "[0, 1, 0]");
  return done();
}

// A four-bar whose crank and rocker hang or stand in parallel, an equilibrium whatever their lengths. Its loop leaves one freedom, or
// none where the crank is driven or a coupler ties both.
Scene RigidMaker::four_bar() {
  const double width = number(0.3, 1.0), crank = number(0.4, 1.0), rocker = number(0.4, 1.0);
  head_ = fmt::format("gravity = [0, 0, {}]\n", number(-9.81, 9.81));
  text_ = fmt::format(
      "[ground.marker.o]\n[body.c]\nmass = 1\ninertia = [0.1, 0.1, 0.1]\nposition = [0, 0, {1}]\n"
      "[body.c.marker.l]\naxis = [0, 1, 0]\n[body.c.marker.r]\nposition = [{0}, 0, {2:.17g}]\naxis = [0, 1, "
      "0]\n",
      width, crank, rocker - crank);
  const int kind = chance_.below(3);
  cranks(width, crank, rocker, 0.0, kind == 0 ? drive("l.angle", "l.speed", "r.angle") : "");
  if (kind == 1) joint_force("f", "r", feedback("r.angle", "r.speed"));
  if (kind == 2) coupler("lc", "r");
  motion("l.angle");
  motion("r.angle");
  further("r.speed");
  place("c.r", "[1, 0, 0]");
  load("r", "[1, 0, 0]");
  return done();
}

// A pendulum on a body that turns as angles or a rotation vector say.
Scene RigidMaker::gimbal() {
  head_ = fmt::format("gravity = [0, 0, {}]\n", number(-9.81, 9.81));
  text_ = "[ground.marker.o]\n[body.b0]\nmass = 1\ninertia = [0.1, 0.2, 0.3]\n[body.b0.marker.o]\n";
  marker("body.b0", "p", number(0.0, 0.3), "[0, 1, 0]");
  body("b1", number(0.3, 1.0));
  marker("body.b1", "o", 0.0, "[0, 1, 0]");
  joint("r1", "revolute", "b0.p", "b1.o");
  static constexpr const char* kSequences[] = {"xyz", "yzx", "zyx"};
  const bool by_angles = chance_.flip(0.6);
  std::string keys = by_angles ? fmt::format("drive_sequence = \"{}\"\n", chance_.one_of(kSequences)) : "";
  for (int i = 0; i < 3; ++i)
    if (i == 1 || chance_.flip(0.5))
      keys += by_angles ? fmt::format("drive_angle_{} = \"{}\"\n", i + 1, followed())
                        : fmt::format("drive_rotation_{} = \"{}\"\n", "xyz"[i], followed());
  joint("h", "spherical", "ground.o", "b0.o", keys);
  if (chance_.flip(0.6)) joint_force("t", "r1", feedback("r1.angle", "r1.speed"));
  motion("r1.angle");
  further("h.omega_y");
  place("b1.o", "[1, 0, 0]");
  load("h", "[1, 0, 0]");
  return done();
}

TEST(Linear, SystemsPredictTheRunsOfRigidMechanisms) {
  const test::Folder folder;
  int n_growing = 0;
  for (int seed = 1; seed <= 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed));
    RigidMaker maker(chance);
    const int kind = chance.below(14);
    const Scene scene = kind < 7    ? maker.chain()
                        : kind < 9  ? maker.rotor()
                        : kind < 10 ? maker.disc()
                        : kind < 12 ? maker.gimbal()
                                    : maker.four_bar();
    SCOPED_TRACE(fmt::format("seed {}\n{}{}", seed, scene.head, scene.text));
    n_growing += expect_predicted(scene, chance, folder) ? 1 : 0;
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_GT(n_growing, 30);
}

}  // namespace
}  // namespace flexura::properties
