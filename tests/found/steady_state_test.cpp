// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What `eigen`, `linearize` and `statics` say of states that last and of such that do not.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;
const std::filesystem::path found = std::filesystem::path(FLEXURA_SOURCE_DIR) / "tests/found/flex/eigen_free";

class SteadyState : public ::testing::Test {
 protected:
  Outcome flexura(const std::string& command, const std::filesystem::path& file,
                  const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {command, file};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run("flexura", arguments);
  }
  nlohmann::json eigen(const std::filesystem::path& file, std::vector<std::string> more = {}) {
    more.push_back("--json");
    const Outcome outcome = flexura("eigen", file, more);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.exit_code == 0 ? nlohmann::json::parse(outcome.out)["runs"][0] : nlohmann::json();
  }
  void expect_refused(const std::filesystem::path& file, const std::string& why,
                      const std::vector<std::string>& more = {}) {
    for (const char* command : {"eigen", "linearize"}) {
      std::vector<std::string> with = more;
      if (std::string(command) == "linearize") with.insert(with.end(), {"-o", folder_ / "x.m"});
      const Outcome outcome = flexura(command, file, with);
      EXPECT_EQ(outcome.exit_code, 2) << command << outcome.out;
      EXPECT_THAT(outcome.err, AllOf(HasSubstr(why), HasSubstr("--frozen"))) << command;
      EXPECT_FALSE(std::filesystem::exists(folder_ / "x.m"));
      with.push_back("--frozen");
      const Outcome frozen = flexura(command, file, with);
      EXPECT_EQ(frozen.exit_code, 0) << command << frozen.err;
      EXPECT_THAT(frozen.out, HasSubstr("frozen at t = 0 s"));
      std::filesystem::remove(folder_ / "x.m");
    }
  }
  static std::vector<double> frequencies(const nlohmann::json& run, double below) {
    std::vector<double> out;
    for (const auto& mode : run["modes"])
      if (const double f = mode["frequency_hz"]; f > 1e-3 && f < below) out.push_back(f);
    return out;
  }
  static double growth(const nlohmann::json& run) {
    double out = 0.0;
    for (const auto& mode : run["modes"]) out = std::max(out, mode["real_1_s"].get<double>());
    return out;
  }
  Folder folder_;
};

TEST_F(SteadyState, AShaftOnAFreeJointTurnsInItsOwnAxesAsOneInARevolute) {
  const Outcome reduced = run("flexura", {"reduce", found / "sh.toml", "-q", "-o", folder_ / "sh.se.h5"});
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  const std::string se = "body.s.superelement=\"" + (folder_ / "sh.se.h5").string() + "\"";
  const nlohmann::json free = eigen(found / "w3.toml", {"--fixed-axes", "--set", se}),
                       revolute = eigen(found / "w4.toml", {"--fixed-axes", "--set", se});
  EXPECT_EQ(free["about"], "steady motion");
  EXPECT_THAT(free["axes"].get<std::string>(), HasSubstr("axes that turn"));
  EXPECT_EQ(revolute["axes"], "");
  // 3.84 and 25.60 Hz are the two whirls less and plus the speed; the hub of w4 adds 1e-6 of the inertia.
  // Whirls alone: the drive of w4 holds the twist, which is free in w3.
  const auto whirls = [](const nlohmann::json& run) {
    std::vector<double> out;
    for (const auto& mode : run["modes"])
      if (const double f = mode["frequency_hz"];
          f > 1e-3 && f < 400.0 && mode["fixed_axes"][0]["kind"] == "circular")
        out.push_back(f);
    return out;
  };
  const std::vector<double> a = whirls(free), b = whirls(revolute);
  ASSERT_GE(b.size(), 4u);
  ASSERT_GE(a.size(), 4u);
  EXPECT_NEAR(a[0], 3.84, 0.01);
  EXPECT_NEAR(a[1], 25.60, 0.01);
  for (const double f : b) {
    const bool there = std::any_of(a.begin(), a.end(), [&](double x) { return std::abs(x - f) < 1e-4 * f; });
    EXPECT_TRUE(there) << f;
  }
}

std::string body(double A, double B, double C, const std::string& rest) {
  return fmt::format("gravity = [0, 0, 0]\n[body.b]\nmass = 2\ninertia = [{}, {}, {}]\n", A, B, C) + rest;
}
std::string spin(double x, double y, double z) {
  return fmt::format(
      "[joint.j]\ntype = \"free\"\nfrom = \"ground\"\nto = \"b\"\nomega_x = {}\nomega_y = {}\nomega_z = {}\n",
      x, y, z);
}

// Of the disc below: its nutation goes with the spin.
TEST_F(SteadyState, WhirlSpeedsInFixedAxesAreThoseOfTheDiscItself) {
  const nlohmann::json run =
      eigen(folder_.write("m.toml", body(0.3, 0.3, 0.4, spin(0, 0, 30))), {"--fixed-axes"});
  bool there = false;
  for (const auto& mode : run["modes"])
    for (const auto& whirl : mode["fixed_axes"])
      there = there || std::abs(whirl["hz"].get<double>() - 30.0 * 0.4 / 0.3 / (2.0 * M_PI)) < 1e-6;
  EXPECT_TRUE(there) << run["modes"].dump();
  const Outcome at_rest =
      flexura("eigen", folder_.write("r.toml", body(0.3, 0.3, 0.4, "")), {"--fixed-axes"});
  EXPECT_EQ(at_rest.exit_code, 2);
  EXPECT_THAT(at_rest.err, HasSubstr("turns steadily"));
}

std::string on_a_slide(const std::string& more) {
  return "gravity = [0, 0, 0]\n[ground]\n[body.m]\nmass = 1\ninertia = [1, 1, 1]\n[joint.s]\ntype = "
         "\"prismatic\"\nfrom = \"ground\"\nto = \"m\"\n" +
         more;
}

// sqrt(150) and 10 rad/s were called the frequencies of a spring with two stiffnesses and of a stop that is just touched.
TEST_F(SteadyState, AtASwitchTheSystemIsSaidToHoldOnOneSide) {
  const std::string spring = "[force.k]\ntype = \"joint_spring_damper\"\njoint = \"s\"\nstiffness = 100\n";
  for (const std::string& more :
       {std::string("[force.f]\ntype = \"joint_force\"\njoint = \"s\"\nvalue = \"-50*abs(s.position)\"\n"),
        std::string("[force.b]\ntype = \"bump_stop\"\njoint = \"s\"\nupper = 0\nstiffness = 1000\n")}) {
    const nlohmann::json run = eigen(folder_.write("m.toml", on_a_slide(spring + more)));
    EXPECT_THAT(run["notes"].dump(), HasSubstr("of one side")) << more;
  }
  EXPECT_THAT(eigen(folder_.write("m.toml", on_a_slide(spring)))["notes"].dump(), Not(HasSubstr("side")));
}

TEST_F(SteadyState, ALoopThroughASampleIsSaidToBeOpen) {
  const std::string file = on_a_slide(
      "[control.c]\ntype = \"sample\"\ninput = \"-100*s.position - 5*s.speed\"\nperiod = 0.05\n"
      "[force.f]\ntype = \"joint_force\"\njoint = \"s\"\nvalue = \"c\"\n");
  EXPECT_THAT(eigen(folder_.write("m.toml", file))["notes"].dump(),
              HasSubstr("control \\\"c\\\" keeps its value"));
}

// A load that changes with time counts with its present value; it hid that the stiffness changes, too.
TEST_F(SteadyState, ALoadOfTimeHidesNoStiffnessOfTime) {
  expect_refused(
      folder_.write("m.toml", on_a_slide("[force.f]\ntype = \"joint_force\"\njoint = \"s\"\nvalue = "
                                         "\"-100*(1 + 0.5*sin(t))*s.position + 5*sin(3*t)\"\n")),
      "coefficients change with time");
}

// A disc (C = 0.4, A = 0.3) nutates with C W / A in axes that stand still.
TEST_F(SteadyState, AFreeDiscNutates) {
  const nlohmann::json run = eigen(folder_.write("m.toml", body(0.3, 0.3, 0.4, spin(0, 0, 30))));
  EXPECT_EQ(run["axes"], "");
  const std::vector<double> f = frequencies(run, 1e9);
  ASSERT_EQ(f.size(), 1u);
  EXPECT_NEAR(f[0], 30.0 * 0.4 / 0.3 / (2.0 * M_PI), 1e-6);
}

// Euler: turning about the axis of C, lambda^2 = -W^2 (C - A)(C - B) / (A B).
TEST_F(SteadyState, AFreeBodyIsUnstableAboutItsIntermediateAxisAlone) {
  const double J[] = {1.0, 2.0, 2.5}, W = 3.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double C = J[axis], A = J[(axis + 1) % 3], B = J[(axis + 2) % 3];
    const nlohmann::json run = eigen(folder_.write(
        "m.toml", body(J[0], J[1], J[2], spin(W * (axis == 0), W * (axis == 1), W * (axis == 2)))));
    EXPECT_THAT(run["axes"].get<std::string>(), HasSubstr("axes that turn"));
    const double square = -W * W * (C - A) * (C - B) / (A * B);
    const bool unstable = square > 0.0;
    EXPECT_EQ(run["stability"] == "unstable", unstable) << axis;
    if (unstable) {
      EXPECT_NEAR(growth(run), std::sqrt(square), 1e-6);
      EXPECT_THAT(run["notes"].dump(), HasSubstr("the steady motion is unstable"));
    } else {
      const std::vector<double> f = frequencies(run, 1e9);
      const bool there = std::any_of(f.begin(), f.end(), [&](double x) {
        return std::abs(x - std::sqrt(-square) / (2.0 * M_PI)) < 1e-6;
      });
      EXPECT_TRUE(there) << axis;
    }
  }
}

// A heavy top, A = 0.02 about its tip, C = 0.01, m g l = 1, precesses at rate p with its axis 0.5 rad off the
// vertical: A p^2 cos + m g l = C w_3 p.  About it the axis nods with V''/A, V = (L_z - L_3 cos)^2 / (2 A
// sin^2)
// + m g l cos (Goldstein, Classical Mechanics, 5.7).
TEST_F(SteadyState, AHeavyTopNodsAboutItsSteadyPrecession) {
  const double A = 0.02, C = 0.01, mgl = 1.0, theta = 0.5, p = 4.0;
  const double w_3 = (A * p * p * std::cos(theta) + mgl) / (C * p);
  const double L_3 = C * w_3, L_z = A * p * std::pow(std::sin(theta), 2) + L_3 * std::cos(theta);
  const auto V = [&](double x) {
    return std::pow(L_z - L_3 * std::cos(x), 2) / (2.0 * A * std::pow(std::sin(x), 2)) + mgl * std::cos(x);
  };
  const double h = 1e-4;
  ASSERT_NEAR((V(theta + h) - V(theta - h)) / (2.0 * h), 0.0, 1e-6);
  const double nod = std::sqrt((V(theta + h) - 2.0 * V(theta) + V(theta - h)) / (h * h) / A);
  // Axis in the xz plane; w = p e_z + spin e_3, spin = w_3 - p cos.
  const double s = w_3 - p * std::cos(theta);
  const std::string top = fmt::format(
      R"toml(
gravity = [0, 0, -10]
[body.b]
mass = 0.1
center = [0, 0, 1]
inertia = [{0}, {0}, {1}]
[joint.j]
type = "spherical"
from = "ground"
to = "b"
qw = {2:.17g}
qy = {3:.17g}
omega_x = {4:.17g}
omega_z = {5:.17g}
)toml",
      A - 0.1, C, std::cos(theta / 2), std::sin(theta / 2), s * std::sin(theta), p + s * std::cos(theta));
  // Inertia about the centre would be negative: put the mass nearer, m l^2 = 0.01 for l = 0.1, m = 1.
  std::string text = replaced(top, "mass = 0.1\ncenter = [0, 0, 1]", "mass = 1\ncenter = [0, 0, 0.1]");
  text = replaced(text, fmt::format("inertia = [{0}, {0}, {1}]", A - 0.1, C),
                  fmt::format("inertia = [{0}, {0}, {1}]", A - 0.01, C));
  const nlohmann::json run = eigen(folder_.write("m.toml", text));
  EXPECT_EQ(run["about"], "steady motion");
  EXPECT_THAT(run["axes"].get<std::string>(), HasSubstr("axes that turn with the precession of \"b\""));
  const std::vector<double> f = frequencies(run, 1e9);
  ASSERT_FALSE(f.empty());
  const bool there = std::any_of(f.begin(), f.end(),
                                 [&](double x) { return std::abs(x - nod / (2.0 * M_PI)) < 1e-5 * nod; });
  EXPECT_TRUE(there) << run["modes"].dump();
  // Slower by 1 %: no steady precession.
  expect_refused(
      folder_.write("n.toml", replaced(text, fmt::format("omega_z = {:.17g}", p + s * std::cos(theta)),
                                       fmt::format("omega_z = {:.17g}", p + 0.99 * s * std::cos(theta)))),
      "neither an equilibrium nor a steady motion");
}

// A rotor between springs: constant coefficients in axes that stand still where the rotor is round, in its
// own where the springs are; where neither is, Mathieu's equation has no eigenvalues.
TEST_F(SteadyState, ARotorOnSpringsNeedsOneRoundSide) {
  const auto tilting = [&](double B, double k) {
    return folder_.write("m.toml", body(0.2, B, 0.4, spin(0, 0, 30)) + fmt::format(R"toml(
[ground.marker.up]
position = [0, 0, 1]
[body.b.marker.up]
position = [0, 0, 0.5]
[ground.marker.x]
position = [1, 0, 0.5]
[ground.marker.y]
position = [0, 1, 0.5]
[ground.marker.xx]
position = [-1, 0, 0.5]
[ground.marker.yy]
position = [0, -1, 0.5]
[force.x]
type = "spring_damper"
from = "ground.x"
to = "b.up"
stiffness = 100
free_length = 1
[force.xx]
type = "spring_damper"
from = "ground.xx"
to = "b.up"
stiffness = 100
free_length = 1
[force.y]
type = "spring_damper"
from = "ground.y"
to = "b.up"
stiffness = {0}
free_length = 1
[force.yy]
type = "spring_damper"
from = "ground.yy"
to = "b.up"
stiffness = {0}
free_length = 1
)toml",
                                                                                   k));
  };
  EXPECT_EQ(eigen(tilting(0.2, 300))["axes"], "");
  EXPECT_THAT(eigen(tilting(0.25, 100))["axes"].get<std::string>(), HasSubstr("axes that turn"));
  expect_refused(tilting(0.25, 300), "the coefficients change along the motion");
}

const std::string kRod = R"toml(
gravity = [0, 0, -9.81]
[ground.marker.o]
axis = [0, 1, 0]
[body.rod]
mass = 2
center = [0, 0, 0.5]
inertia = [0.1, 0.1, 0.001]
[body.rod.marker.o]
axis = [0, 1, 0]
[joint.h]
type = "revolute"
from = "ground.o"
to = "rod.o"
)toml";

TEST_F(SteadyState, AnEquilibriumSaysThatItIsUnstable) {
  const std::filesystem::path upright = folder_.write("m.toml", kRod);
  for (const char* command : {"statics", "eigen"}) {
    const Outcome outcome = flexura(command, upright);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("the equilibrium is unstable")) << command;
  }
  // (J + m l^2 / 4) = 0.6, m g l / 2 = 9.81.
  EXPECT_NEAR(growth(eigen(upright)), std::sqrt(9.81 / 0.6), 1e-6);
  EXPECT_EQ(eigen(upright)["stability"], "unstable");
  const std::filesystem::path hanging = folder_.write("h.toml", kRod + "angle = \"180 deg\"\n");
  EXPECT_EQ(eigen(hanging, {"--equilibrium"})["stability"], "stable");
  EXPECT_THAT(flexura("statics", hanging).out, Not(HasSubstr("stable")));
  // A spring of 9 and one of 11 N m/rad against 9.81.
  const std::string spring = "[force.k]\ntype = \"joint_spring_damper\"\njoint = \"h\"\nstiffness = ";
  EXPECT_EQ(eigen(folder_.write("a.toml", kRod + spring + "9\n"))["stability"], "unstable");
  EXPECT_EQ(eigen(folder_.write("b.toml", kRod + spring + "11\n"))["stability"], "stable");
  // A crank that nothing holds.
  const nlohmann::json loose =
      eigen(folder_.write("c.toml", replaced(kRod, "gravity = [0, 0, -9.81]", "gravity = [0, 0, 0]")));
  EXPECT_EQ(loose["stability"], "unknown");
  EXPECT_THAT(loose["notes"].dump(), HasSubstr("h.speed\\\" moves without stiffness"));
}

// A bar drawn level that its torsion spring (k = 100 N m/rad) lets sag: k a = -m g l cos a, and about there
// omega^2 = (k - m g l sin a) / (m l^2 + I).
TEST_F(SteadyState, WhatStandsBesideItsEquilibriumIsTakenThere) {
  const std::filesystem::path file = folder_.write("sags.toml", R"toml(
gravity = [0, -9.81, 0]
[body.a]
mass = 1
center = [0.5, 0, 0]
inertia = [0.1, 0.1, 0.1]
[joint.h]
type = "revolute"
from = "ground"
to = "a"
[force.k]
type = "joint_spring_damper"
joint = "h"
stiffness = 100
)toml");
  double a = 0.0;
  for (int i = 0; i < 50; ++i) a = -0.5 * 9.81 * std::cos(a) / 100.0;
  const nlohmann::json run = eigen(file);
  EXPECT_NEAR(run["modes"][0]["frequency_hz"].get<double>(),
              std::sqrt((100.0 - 0.5 * 9.81 * std::sin(a)) / 0.35) / (2.0 * M_PI), 1e-6);
  EXPECT_THAT(run["notes"].dump(), HasSubstr("modes about the one beside it"));
}

TEST_F(SteadyState, WhatDoesNotLastIsRefusedOrFrozenByName) {
  expect_refused(folder_.write("m.toml", kRod + "angle = \"30 deg\"\n"), "\"h.speed\" changes by");
  // Through the lowest point with a speed that gravity changes at once after.
  expect_refused(folder_.write("n.toml", kRod + "angle = \"180 deg\"\nspeed = \"2 rad/s\"\n"),
                 "does not go on as it moves now");
  // A stiffness that swings with time, where nothing else moves.
  const std::string swings = replaced(kRod, "gravity = [0, 0, -9.81]", "gravity = [0, 0, 0]") +
                             "[force.k]\ntype = \"joint_force\"\njoint = \"h\"\n"
                             "value = \"-1000*(1 + 0.5*cos(40*t))*h.angle\"\n";
  expect_refused(folder_.write("p.toml", swings), "the coefficients change with time");
  // A load that swings is no coefficient, and a drive that has not begun neither.
  const Outcome load = flexura(
      "eigen", folder_.write("q.toml", kRod + "angle = \"180 deg\"\n[force.f]\ntype = \"joint_force\"\n"
                                              "joint = \"h\"\nvalue = \"3*sin(20*t)\"\n"));
  EXPECT_EQ(load.exit_code, 0) << load.err;
  EXPECT_THAT(load.out, AllOf(HasSubstr("counts with its value at t = 0 s"), HasSubstr("0.64")));
}

// Free fall: everything falls alike, and the coefficients stay.
TEST_F(SteadyState, AFallingBodyHasItsModes) {
  const nlohmann::json run = eigen(folder_.write(
      "m.toml", replaced(body(0.2, 0.2, 0.4, ""), "gravity = [0, 0, 0]", "gravity = [0, 0, -9.81]") + R"toml(
[body.c]
mass = 1
inertia = [1, 1, 1]
[joint.j]
type = "free"
from = "ground"
to = "b"
[joint.p]
type = "prismatic"
from = "b"
to = "c"
[force.k]
type = "joint_spring_damper"
joint = "p"
stiffness = 600
)toml"));
  // Two masses 2 and 1 on a spring: sqrt(600 (1/2 + 1)) = 30.
  const std::vector<double> f = frequencies(run, 1e9);
  ASSERT_EQ(f.size(), 1u);
  EXPECT_NEAR(f[0], 30.0 / (2.0 * M_PI), 1e-6);
  EXPECT_THAT(run["notes"].dump(), HasSubstr("gathers speed"));
}

}  // namespace
}  // namespace flexura::test
