// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A bar on a torsion spring k = 1000 N m/rad under 100 N at l = 1 m: K = k - lambda P l, factor 10, whatever
// the load is made of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
const std::filesystem::path found = std::filesystem::path(FLEXURA_SOURCE_DIR) / "tests/found/buckling";

class Buckling : public ::testing::Test {
 protected:
  nlohmann::json run_of(const std::filesystem::path& file, const std::vector<std::string>& set = {}) {
    std::vector<std::string> arguments = {"eigen", file, "--buckling", "--json"};
    for (const std::string& one : set) arguments.insert(arguments.end(), {"--set", one});
    const Outcome outcome = run("flexura", arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    if (outcome.exit_code != 0) return {};
    return nlohmann::json::parse(outcome.out)["runs"][0];
  }
  // K is exact but for differences of users' elements: 1e-9, times the factor.
  void expect_ten(const nlohmann::json& run) {
    ASSERT_EQ(run["modes"].size(), 1u) << run;
    EXPECT_NEAR(run["modes"][0]["load_factor"].get<double>(), 10.0, 1e-6);
  }
  Folder folder_;
};

TEST_F(Buckling, FactorIsTheSameForEachKindOfLoad) {
  expect_ten(run_of(found / "builtin.toml"));
  expect_ten(run_of(found / "user.toml", {std::string("force.load.library=\"") + FLEXURA_DEAD_LOAD + "\""}));
  // Along lines to points 1 km away the forces keep their directions but for 1/1001: the true factor is
  // k / (P l) (1 + l / 1000), 10.01.
  for (const char* file : {"actuator.toml", "preload.toml"}) {
    const nlohmann::json modes = run_of(found / file)["modes"];
    ASSERT_EQ(modes.size(), 1u) << file;
    EXPECT_NEAR(modes[0]["load_factor"].get<double>(), 10.0 * 1.001, 1e-5) << file;
  }
}

std::string bar(const std::string& spring, const std::string& load) {
  const std::string text = read_text(found / "builtin.toml");
  const std::size_t forces = text.find("[force.k]");
  return text.substr(0, forces) + spring + load;
}
const std::string kSpring = "[force.k]\ntype=\"joint_spring_damper\"\njoint=\"h\"\nstiffness=1000\n";
const std::string kLoad = "[force.load]\ntype=\"force\"\nmarker=\"bar.tip\"\nz=-100\n";

TEST_F(Buckling, SpringsByFormulaAreNoLoads) {
  expect_ten(run_of(folder_.write(
      "spring.toml", bar("[force.k]\ntype=\"joint_force\"\njoint=\"h\"\nvalue=\"-1000*h.angle\"\n", kLoad))));
  // Half of the spring in an actuator's command, whose state follows it.
  expect_ten(run_of(folder_.write(
      "servo.toml", bar("[force.k]\ntype=\"joint_spring_damper\"\njoint=\"h\"\nstiffness=500\n[force.s]\n"
                        "type=\"actuator\"\njoint=\"h\"\ncommand=\"-500*h.angle\"\ntime_constant=\"1 s\"\n",
                        kLoad))));
  // Weight alone: m g l / 2 = 50 N m/rad.
  const nlohmann::json weight =
      run_of(folder_.write("weight.toml", replaced(bar(kSpring, ""), "[0, 0, 0]", "[0, 0, -100]")));
  ASSERT_EQ(weight["modes"].size(), 1u);
  EXPECT_NEAR(weight["modes"][0]["load_factor"].get<double>(), 20.0, 1e-6);
}

// What follows its command gives nothing at the start, and all of it in the equilibrium: "the loads change no stiffness".
TEST_F(Buckling, LoadsThatBuildUpCountAsTheyAreInTheEquilibrium) {
  expect_ten(run_of(folder_.write(
      "filter.toml", bar(kSpring, "[control.c]\ntype=\"filter\"\ninput=\"-100\"\ntime_constant=1\n" +
                                      replaced(kLoad, "z=-100", "z=\"c\"")))));
  const nlohmann::json modes = run_of(found / "actuator.toml", {"force.load.start=0"})["modes"];
  ASSERT_EQ(modes.size(), 1u);
  EXPECT_NEAR(modes[0]["load_factor"].get<double>(), 10.0 * 1.001, 1e-5);
}

// 100 N at 1 s: nothing at 0 s, and half at 0.5 s. Weight beside it is scaled alone (as above).
TEST_F(Buckling, LoadsThatAreNotThereYetAreNamed) {
  const auto says = [](const nlohmann::json& run) {
    EXPECT_THAT(run["notes"].dump(),
                AllOf(HasSubstr("\\\"load\\\" is nothing at t = 0 s"), HasSubstr("solver.start_time=1,")));
  };
  const std::string ramp = replaced(kLoad, "z=-100", "z=\"-100*min(t,1)\"");
  const auto file = folder_.write("ramp.toml", bar(kSpring, ramp));
  const nlohmann::json none = run_of(file);
  EXPECT_TRUE(none["modes"].empty());
  says(none);
  expect_ten(run_of(file, {"solver.start_time=1"}));
  const nlohmann::json half = run_of(file, {"solver.start_time=0.5"});
  ASSERT_EQ(half["modes"].size(), 1u);
  EXPECT_NEAR(half["modes"][0]["load_factor"].get<double>(), 20.0, 1e-6);
  EXPECT_THAT(half["notes"].dump(), Not(HasSubstr("is nothing")));
  const nlohmann::json weight =
      run_of(folder_.write("both.toml", replaced(bar(kSpring, ramp), "[0, 0, 0]", "[0, 0, -100]")));
  ASSERT_EQ(weight["modes"].size(), 1u);
  EXPECT_NEAR(weight["modes"][0]["load_factor"].get<double>(), 20.0, 1e-6);
  says(weight);
}

// A motor that follows a ramp: its state was left where it is at the start, nothing, and so nothing was said.
TEST_F(Buckling, MotorsThatFollowARampAreNamed) {
  const nlohmann::json run =
      run_of(found / "actuator.toml", {"force.load.start=0", "force.load.command=-100*min(t,1)"});
  EXPECT_TRUE(run["modes"].empty());
  EXPECT_THAT(run["notes"].dump(), HasSubstr("\\\"load\\\" is nothing at t = 0 s"));
}

TEST_F(Buckling, WithoutLoadsThereIsNothingToScale) {
  const Outcome none = run("flexura", {"eigen", folder_.write("none.toml", bar(kSpring, "")), "--buckling"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.err, HasSubstr("the mechanism has none"));
}

TEST_F(Buckling, WhatIsWeldedBucklesAtNoLoad) {
  std::string text = replaced(bar("", ""), "\"revolute\"", "\"fixed\"");
  const nlohmann::json run =
      run_of(folder_.write("welded.toml", replaced(text, "[0, 0, 0]", "[0, 0, -100]")));
  EXPECT_TRUE(run["modes"].empty());
  EXPECT_THAT(run["notes"].dump(), HasSubstr("nothing of the mechanism moves or deforms"));
}

// H. Ziegler, Ingenieur-Archiv 20 (1952) 49: two bars on springs under a force along the outer one flutter,
// and at no load is there another equilibrium.
TEST_F(Buckling, FollowingForcesTakeNoStiffnessAway) {
  const std::string ziegler = R"toml(
gravity = [0, 0, 0]
[ground.marker.o]
axis = [0, 1, 0]
[body.a]
mass = 2
inertia = [0.1, 0.1, 0.1]
center = [0, 0, 1]
[body.a.marker.o]
axis = [0, 1, 0]
[body.a.marker.end]
position = [0, 0, 1]
axis = [0, 1, 0]
[body.b]
mass = 1
inertia = [0.1, 0.1, 0.1]
center = [0, 0, 1]
[body.b.marker.o]
axis = [0, 1, 0]
[body.b.marker.tip]
position = [0, 0, 1]
[joint.h]
type = "revolute"
from = "ground.o"
to = "a.o"
[joint.g]
type = "revolute"
from = "a.end"
to = "b.o"
[force.k]
type = "joint_spring_damper"
joint = "h"
stiffness = 1000
[force.c]
type = "joint_spring_damper"
joint = "g"
stiffness = 1000
[force.load]
type = "force"
marker = "b.tip"
axes = "b.tip"
z = -100
)toml";
  const nlohmann::json one = run_of(folder_.write("ziegler.toml", ziegler));
  EXPECT_TRUE(one["modes"].empty()) << one;
  EXPECT_THAT(one["notes"].dump(), AllOf(HasSubstr("does not buckle by divergence"), HasSubstr("flutter")));
  // A dead load in its place: (2 - x)(1 - x) = 1, x = P l / k = (3 - sqrt 5) / 2.
  const nlohmann::json dead = run_of(folder_.write("dead.toml", replaced(ziegler, "axes = \"b.tip\"\n", "")));
  EXPECT_NEAR(dead["modes"][0]["load_factor"].get<double>(), 10.0 * (3.0 - std::sqrt(5.0)) / 2.0, 1e-5);
  // Above P l / k = 2.09 or so with these masses the equilibrium flutters, and eigen says it.
  const Outcome flutter =
      run("flexura", {"eigen", folder_ / "ziegler.toml", "--equilibrium", "--set", "force.load.z=-4000"});
  EXPECT_EQ(flutter.exit_code, 0) << flutter.err;
  EXPECT_THAT(flutter.out, HasSubstr("unstable"));
}

// The shipped magnet pulls harder the nearer it is, and does not say what of it is a load.
TEST_F(Buckling, AnElementThatDoesNotSayWhatItIsIsAsked) {
  const std::string magnet = bar(kSpring, R"toml([ground.marker.far]
position = [0, 0, -1]
[force.pull]
type = "user"
element = "magnet"
markers = ["bar.tip", "ground.far"]
values = { strength = "400" }
)toml");
  const Outcome outcome =
      run("flexura", {"eigen", folder_.write("magnet.toml", magnet), "--buckling", "--set",
                      std::string("force.pull.library=\"") + FLEXURA_USER_LIBRARY + "\""});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("\"pull\" does not say"), HasSubstr("nature()")));
}

}  // namespace
}  // namespace flexura::test
