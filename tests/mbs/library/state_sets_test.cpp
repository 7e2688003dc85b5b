// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mbs/library/simulation.hpp"
#include "tests/mbs/test_folder.hpp"

/// Named sets of states, listed and applied by a program.
namespace flexura::mbs {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// A mass on a spring of 100 N/m (10 rad/s), hung so that it stands 0.0981 m below.
const std::string kText = R"toml(
gravity = [0, 0, -9.81]
[ground.marker.o]
axis = [0, 0, 1]
[body.b]
mass = 1
inertia = [1, 1, 1]
[body.b.marker.c]
axis = [0, 0, 1]
[joint.s]
type = "prismatic"
from = "ground.o"
to = "b.c"
[force.spring]
type = "joint_spring_damper"
joint = "s"
stiffness = 100
[state.low]
values = { "s.position" = -0.3, "s.speed" = 0.5 }
[state.late]
values = { "s.position" = 0.1 }
time = 2
[state.still]
equilibrium = true
[solver]
end_time = 10
)toml";

double height(double t, double x, double v) {
  const double rest = -0.0981;
  return rest + (x - rest) * std::cos(10 * t) + v / 10 * std::sin(10 * t);
}

class StateSets : public test::TestFolder {
 protected:
  PreparedMechanism prepared(const std::string& more = "") const { return prepare(file(kText + more)); }
};

TEST_F(StateSets, AreListedAndApplied) {
  Simulation s(prepared(), {.tolerance = 1e-9});
  EXPECT_THAT(s.state_sets(), ElementsAre("zero", "low", "late", "still"));
  s.advance(0.3);
  for (const auto& [set, x, v] :
       {std::tuple("low", -0.3, 0.5), std::tuple("zero", 0.0, 0.0), std::tuple("still", -0.0981, 0.0)}) {
    s.start_from(set);
    EXPECT_EQ(s.time(), 0.0);
    EXPECT_EQ(s.energy().dissipated, 0.0);
    for (int k = 1; k <= 10; ++k) {
      s.advance(0.05);
      EXPECT_NEAR(s.output("s.position"), height(0.05 * k, x, v), 1e-6) << set;
    }
  }
  s.start_from("late");
  EXPECT_EQ(s.time(), 2.0);
  s.advance(0.1);
  EXPECT_NEAR(s.output("s.position"), height(0.1, 0.1, 0.0), 1e-6);
}

TEST_F(StateSets, OfTheFilesChoiceAreTheStart) {
  const Simulation s(prepared("initial_state = \"low\"\n"));
  EXPECT_EQ(s.output("s.position"), -0.3);
  EXPECT_EQ(s.output("s.speed"), 0.5);
}

TEST_F(StateSets, OfTheProgramAreApplied) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-0.5, 0.5);
  Simulation s(prepared(), {.tolerance = 1e-9});
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    const double x = number(random), v = number(random), t = 0.5 + number(random);
    s.add_state_set({.name = "mine",
                     .where = "mine",
                     .values = {{"s.position", {.value = x}, "x"}, {"s.speed", {.value = v}, "v"}},
                     .time = t});
    s.start_from("mine");
    EXPECT_EQ(s.time(), t);
    s.advance(0.1);
    EXPECT_NEAR(s.output("s.position"), height(0.1, x, v), 1e-6);
  }
  EXPECT_THAT(s.state_sets(), ElementsAre("zero", "low", "late", "still", "mine"));
}

TEST_F(StateSets, AreRefusedByName) {
  Simulation s(prepared());
  s.advance(0.1);
  const double before = s.output("s.position");
  EXPECT_THAT([&] { s.start_from("lov"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("did you mean \"low\"")));
  s.add_state_set({.name = "odd", .where = "odd", .values = {{"s.angle", {.value = 1.0}, "s.angle"}}});
  EXPECT_THAT([&] { s.start_from("odd"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("is none of the mechanism's states")));
  EXPECT_EQ(s.output("s.position"), before);  // nothing has changed
  EXPECT_THAT([&] { s.add_state_set({.name = "zero"}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("zero")));
}

}  // namespace
}  // namespace flexura::mbs
