// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// Events that every integrator stepped over (trade/scene_impulse_*), with "estimated error 0 %" and exit 0.
namespace flexura::test {
namespace {

const std::string trade = FLEXURA_SOURCE_DIR "/tests/found/trade/";

results::Run simulated(const Folder& folder, const std::filesystem::path& scene, const std::string& method,
                       const std::string& end_time = "1") {
  const std::filesystem::path output = folder / (method + scene.stem().string() + ".h5");
  const Outcome outcome =
      run("flexura", {"simulate", scene.string(), "-q", "--no-estimate", "-o", output, "--set",
                      "solver.method=" + method, "--set", "solver.end_time=" + end_time});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return results::read(output).runs.at(0);
}

Eigen::VectorXd values(const results::Run& run, const std::string& name) {
  for (std::size_t i = 0; i < run.quantities.size(); ++i)
    if (run.quantities[i].name == name) return run.values.col(static_cast<Eigen::Index>(i));
  throw std::out_of_range(name);
}

class Events : public ::testing::TestWithParam<const char*> {};

TEST_P(Events, ALateImpulseMovesARigidMass) {
  const Folder folder;
  const results::Run run = simulated(folder, trade + "scene_impulse_rigid_late.toml", GetParam());
  const Eigen::VectorXd speed = values(run, "s.speed");
  EXPECT_NEAR(speed(speed.size() - 1), 10.0, 1e-9);
  // The row at 0.5 s is that before it; at 0.51 s all of it is there.
  for (Eigen::Index i = 0; i < speed.size(); ++i)
    EXPECT_NEAR(speed(i), 1000.0 * std::clamp(0.002 * static_cast<double>(i) - 0.5, 0.0, 0.01), 1e-9);
}

// Each has the impulse 1 N s on 1 kg that stood still until then.
TEST_P(Events, SpikesOfAMicrosecondAreWhole) {
  const Folder folder;
  const std::string mechanism = R"(gravity = [0, 0, 0]
[ground.marker.A]
axis = [1, 0, 0]
[body.m]
mass = 1
inertia = [0.01, 0.01, 0.01]
marker.a = {axis = [1, 0, 0]}
[joint.s]
type = "prismatic"
from = "ground.A"
to = "m.a"
[table.spike]
x = [0, 2, 2.000001, 2.000002, 10]
y = [0, 0, 1e6, 0, 0]
interpolation = "linear"
[force.f]
type = "joint_force"
joint = "s"
value = "FORMULA"
[solver]
output_step = 0.1
)";
  for (const std::string formula :
       {"spike(t)", "t > 3.3333 && t < 3.3333 + 1e-6 ? 1e6 : 0", "5e4*(abs(t - 5) < 1e-5)"}) {
    const results::Run run = simulated(
        folder, folder.write("spike.toml", replaced(mechanism, "FORMULA", formula)), GetParam(), "10");
    const Eigen::VectorXd speed = values(run, "s.speed");
    // The tolerance of 1e-6 a step, of a hundred steps that mostly have nothing to do.
    EXPECT_NEAR(speed(speed.size() - 1), 1.0, 1e-6) << formula;
  }
}

// A drive by its acceleration has the speed that all of it has made, a pulse of a microsecond and one that is round-off of its
// terms where it begins (whose integral was never done).
TEST_P(Events, ADriveByItsAccelerationHasAllOfTheSpeed) {
  const Folder folder;
  const std::string mechanism = R"(gravity = [0, 0, 0]
[body.b]
mass = 1
inertia = [1, 1, 1]
[joint.j]
type = "revolute"
from = "ground"
to = "b"
drive_acceleration = "FORMULA"
[solver]
output_step = 0.1
[ground]
)";
  for (const std::string formula : {"t > 0.7 && t < 0.700001 ? 1e6 : 0",
                                    "t < 0.1 ? 10*(1 - cos(2*pi*t/0.1)) : 0", "5e4*(abs(t - 0.5) < 1e-5)"}) {
    const results::Run run = simulated(
        folder, folder.write("driven.toml", replaced(mechanism, "FORMULA", formula)), GetParam(), "1");
    const Eigen::VectorXd speed = values(run, "j.speed");
    EXPECT_NEAR(speed(speed.size() - 1), 1.0, 1e-6) << formula;
  }
}

TEST_P(Events, ALateImpulseRingsAsOneAtTheStart) {
  const Folder folder;
  ASSERT_EQ(run("flexura", {"reduce", trade + "ringer.toml", "-q", "-o", folder / "ringer.se.h5"}).exit_code,
            0);
  const auto scene = [&](const std::string& name) { return folder.write(name, read_text(trade + name)); };
  const results::Run late = simulated(folder, scene("scene_impulse_late.toml"), GetParam(), "0.53");
  // The same with as many modes, hit at once.
  const std::string early_text =
      replaced(read_text(trade + "scene_impulse_late.toml"),
               "t>0.5 && t<0.501 ? 200*sin(pi*(t-0.5)/0.001)^2 : 0", "t<0.001 ? 200*sin(pi*t/0.001)^2 : 0");
  const results::Run early = simulated(folder, folder.write("early.toml", early_text), GetParam(), "0.03");
  const Eigen::VectorXd tip = values(late, "tip"), expected = values(early, "tip");
  EXPECT_EQ(tip.head(1001).cwiseAbs().maxCoeff(), 0.0);
  const double size = expected.cwiseAbs().maxCoeff();
  EXPECT_NEAR(size, 7.5e-3, 0.3e-3);  // 7.5 mm in the whole second
  // Two runs at the default tolerance of 1e-6 a step, of some hundred steps each.
  ASSERT_EQ(expected.size(), 61);
  ASSERT_EQ(tip.size(), 1061);
  EXPECT_LT((tip.tail(61) - expected).cwiseAbs().maxCoeff(), 0.001 * size);
}

std::string slide(const std::string& start, const std::string& more) {
  return "gravity = [0, 0, 0]\n[body.m]\nmass = 1\ninertia = [1, 1, 1]\n[joint.s]\ntype = "
         "\"prismatic\"\nfrom = "
         "\"ground\"\nto = \"m\"\n" +
         start + more + "[output]\nquantities = [\"s.*\"]\n";
}
std::string force(const std::string& value) {
  return "[force.f]\ntype = \"joint_force\"\njoint = \"s\"\nvalue = \"" + value + "\"\n";
}

// A push of 10 kN at the most along 20 mm of a way of 15 m, 2 ms of one second, where formulas bend but never jump:
// k w^2 = 100 J make 10 m/s to sqrt(300) m/s.
TEST_P(Events, AShortBumpAlongTheWayIsNotSteppedOver) {
  const Folder folder;
  const std::string table =
      "[table.bump]\nx = [4.99, 5, 5.01]\ny = [0, 1e4, 0]\ninterpolation = \"linear\"\n";
  int number = 0;
  for (const std::string& law : {force("1e6*max(0, 0.01 - abs(s.position - 5))"),
                                 force("max(0, min(1e6*(s.position - 4.99), 1e6*(5.01 - s.position)))"),
                                 table + force("bump(s.position)")}) {
    const auto scene = folder.write(std::to_string(++number) + ".toml", slide("speed = 10\n", law));
    const Eigen::VectorXd speed = values(simulated(folder, scene, GetParam()), "s.speed");
    // 1e-6 a step, of some dozens of steps.
    EXPECT_NEAR(speed(speed.size() - 1), std::sqrt(300.0), 1e-3) << law;
  }
}

// Drag by v |v| and a spring that is soft to one side: what swings out about two kinks goes on to its end.
TEST_P(Events, WhatComesToRestAtAKinkGoesOn) {
  const Folder folder;
  const auto scene = folder.write(
      "m.toml",
      slide("position = 1e-3\n",
            force("-40*max(s.position, 0) - 90*min(s.position, 0) - 4*s.speed - s.speed*abs(s.speed)")));
  const Eigen::VectorXd x = values(simulated(folder, scene, GetParam(), "20"), "s.position");
  EXPECT_LT(std::abs(x(x.size() - 1)), 1e-9);
}

// A ball on a floor of k x^1.5: the power has no value on the far side of max's kink, where trial steps lead. What it
// comes back with is what it fell with, sqrt(2 g h).
TEST_P(Events, APowerOfMaxHasValuesBeyondTheKink) {
  const Folder folder;
  const auto scene =
      folder.write("m.toml", slide("position = 1\n", force("-10 + 1e5*max(0, -s.position)^1.5")));
  const Eigen::VectorXd x = values(simulated(folder, scene, GetParam(), "0.918"), "s.position");
  // 2 sqrt(2 h / g) = 0.894 s in the air, and H. Hertz's 2.94 d / v = 24 ms on the floor, d = (5 m v^2 / 4 k)^0.4 = 36 mm:
  // within 4 ms of the top it is 0.1 mm below.
  EXPECT_NEAR(x.tail(1)(0), 1.0, 2e-4);
}

INSTANTIATE_TEST_SUITE_P(Methods, Events,
                         ::testing::Values("ida", "radau", "runge_kutta", "generalised_alpha"));

// Pulses of 0.05 s every half second, seen every 0.02 s: three samples each, on 2 kg. Their times were added up, and what
// that left of round-off decided which side of a jump a sample saw: 26 or 27 of the 30, by the method.
TEST_P(Events, SamplesSeeWhatJumpsWithThem) {
  const Folder folder;
  folder.write("sampled.toml", R"(gravity = [0, 0, 0]
[ground.marker.A]
axis = [1, 0, 0]
[body.m]
mass = 2
inertia = [1, 1, 1]
marker.a = {axis = [1, 0, 0]}
[joint.s]
type = "prismatic"
from = "ground.A"
to = "m.a"
[control.h]
type = "sample"
input = "mod(t, 0.5) < 0.05 ? 10 : 0"
period = "0.02 s"
[force.f]
type = "force"
marker = "m.a"
x = "h"
)");
  const Eigen::VectorXd speed =
      values(simulated(folder, folder / "sampled.toml", GetParam(), "5"), "s.speed");
  EXPECT_NEAR(speed(speed.size() - 1), 30 * 0.02 * 10.0 / 2.0, 1e-9);
}

// stiffness = "t > 0.5 ? 1e4 : 0" was taken at t = 0 for the whole run, without a word.
TEST(OneNumber, ForTheWholeRunIsNoFormulaOfTheTime) {
  const Folder folder;
  const std::string
      spring = "[force.k]\ntype = \"joint_spring_damper\"\njoint = \"s\"\n",
      stop = "[force.k]\ntype = \"bump_stop\"\njoint = \"s\"\n",
      motor = "[force.k]\ntype = \"actuator\"\njoint = \"s\"\ncommand = 1\ntime_constant = \"1 s\"\n",
      friction = "[force.k]\ntype = \"joint_friction\"\njoint = \"s\"\n",
      pid = "[control.c]\ntype = \"pid\"\nerror = \"-s.position\"\n";
  const std::pair<std::string, std::string> keys[] = {{spring, "stiffness"},
                                                      {spring, "damping"},
                                                      {spring, "rest"},
                                                      {spring, "preload"},
                                                      {stop + "upper = 1\n", "stiffness"},
                                                      {stop + "stiffness = 1\n", "upper"},
                                                      {motor, "max_force"},
                                                      {motor, "start"},
                                                      {friction, "coulomb"},
                                                      {pid, "proportional"},
                                                      {pid, "upper"}};
  for (const auto& [element, key] : keys) {
    const Outcome outcome =
        run("flexura", {"simulate", folder.write("m.toml", slide("", element + key + " = \"1 + t\"\n")), "-o",
                        folder / "x.h5"});
    EXPECT_EQ(outcome.exit_code, 2) << key;
    EXPECT_NE(outcome.err.find("reads the time t, and is one number for the whole run"), std::string::npos)
        << key << ": " << outcome.err;
  }
  folder.write("part.toml", "[parameters]\nx = 1\n" + slide("", ""));
  const Outcome outcome =
      run("flexura",
          {"check",
           folder.write("whole.toml", "[subsystem.p]\nfile = \"part.toml\"\nparameters = {x = \"2*t\"}\n")});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("reads the time t"), std::string::npos) << outcome.err;
}

// An algebraic signal after a bell: the equation's residual is a difference of numbers like 1e-300 there, whose tails were
// taken for peaks of a force, until steps crept.
TEST(Tails, OfABellInAnAlgebraicSignalAreNoPeaks) {
  const Folder folder;
  const auto scene = folder.write(
      "m.toml",
      slide("", "[control.a]\ntype = \"algebraic\"\nequation = \"a + a^3 - 10*exp(-((t-5)/1e-3)^2)\"\n" +
                    force("a")));
  for (const std::string method : {"ida", "runge_kutta"}) {
    const Outcome outcome = run("flexura", {"simulate", scene, "-q", "--no-estimate", "-o", folder / "x.h5",
                                            "--set", "solver.method=" + method, "--set", "solver.end_time=10",
                                            "--set", "solver.max_steps=5000"});
    ASSERT_EQ(outcome.exit_code, 0) << method << outcome.err;
    const results::Run one = results::read(folder / "x.h5").runs.at(0);
    // The integral of the real root over time, by Gauss' rule of 400 points, outside of this program.
    EXPECT_NEAR(values(one, "s.speed").tail(1)(0), 5.046795e-3, 1e-7 + 1e-5 * 5.046795e-3) << method;
  }
}

// Equilibria see events, too: x = F(t) / k, of a force that begins at 0.5 s (the row there is that before), and one that
// is there for 1e-9 s only, on a row of its own.
// asin has no value beyond 1, which 1e6 sin(10 t) reaches after 1e-7 s; the search for its jumps never ended.
TEST(KnownTimes, AFormulaWithoutValuesEndsTheRunWhereTheyEnd) {
  const Folder folder;
  std::ifstream in(FLEXURA_SOURCE_DIR "/tests/found/rigid/check_integrator_noise.toml");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const Outcome outcome =
      run("flexura", {"simulate", folder.write("axis.toml", replaced(text, "h=0.1", "h=1e6")), "-o",
                      folder / "axis.h5", "--set", "solver.method=runge_kutta"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(
      outcome.err.find("joint.plate.drive cannot be followed beyond t = 1e-07 s: it has no value there"),
      std::string::npos)
      << outcome.err;
}

TEST(QuasiStatics, FollowsWhatJumpsWithTime) {
  const Folder folder;
  const std::string spring = "[force.k]\ntype = \"joint_spring_damper\"\njoint = \"s\"\nstiffness = 100\n";
  const auto scene = folder.write(
      "m.toml", slide("", spring + force("(t > 0.5 ? 10 : 0) + (t > 0.7 - 1e-9 && t < 0.7 + 1e-9 ? 5 : 0)")));
  const results::Run run = simulated(folder, scene, "quasi_statics");
  const Eigen::VectorXd x = values(run, "s.position");
  ASSERT_EQ(x.size(), 101);
  for (Eigen::Index i = 0; i < x.size(); ++i)
    EXPECT_NEAR(x(i), i <= 50 ? 0.0 : i == 70 ? 0.15 : 0.1, 1e-12) << i;
}

}  // namespace
}  // namespace flexura::test
