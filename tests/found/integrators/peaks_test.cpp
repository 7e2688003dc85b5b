// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

/// Short events of the motion, not of the time: bumps that a body runs over, and small things that fly past or into each
/// other.  Every integrator leapt over them, with an estimated error of 1e-11 % and exit code 0.
namespace flexura::test {
namespace {

// What a quantity is at the end of a run.
double last(const Folder& folder, const std::string& mechanism, const std::string& name,
            const std::vector<std::string>& set = {}) {
  const std::filesystem::path output = folder / "out.h5";
  std::vector<std::string> arguments = {
      "simulate", folder.write("mechanism.toml", mechanism), "-q", "--no-estimate", "-o", output};
  for (const std::string& word : set) arguments.insert(arguments.end(), {"--set", word});
  const Outcome outcome = run("flexura", arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  if (outcome.exit_code != 0) return NAN;
  const results::Run run = results::read(output).runs.at(0);
  for (std::size_t i = 0; i < run.quantities.size(); ++i)
    if (run.quantities[i].name == name)
      return run.values(run.values.rows() - 1, static_cast<Eigen::Index>(i));
  throw std::out_of_range(name);
}

// 1 kg at 1 m/s along x.
std::string slider(const std::string& force) {
  return R"toml(gravity = [0, 0, 0]
[ground.marker.A]
axis = [1, 0, 0]
[ground.marker.B]
position = [-1, 0, 0]
[body.m]
mass = 1
inertia = [0.01, 0.01, 0.01]
marker.a = { axis = [1, 0, 0] }
[joint.s]
type = "prismatic"
from = "ground.A"
to = "m.a"
speed = 1
[table.bump]
x = [0, 0.5, 0.5005, 0.501, 2]
y = [0, 0, 2000, 0, 0]
interpolation = "linear"
[table.pull]
x = [0, 1.3, 1.4, 1.5, 1.5005, 1.501, 1.6, 1.7, 3]
y = [0, 0, 0, 0, -2000, 0, 0, 0, 0]
interpolation = "akima"
)toml" + force;
}

std::string joint_force(const std::string& formula) {
  return "[force.f]\ntype = \"joint_force\"\njoint = \"s\"\nvalue = \"" + formula + "\"\n";
}

struct Bump {
  const char* name;
  std::string force;
  double work;  // [J] that it does
};

// sqrt(pi) J of bells of a millionth, a thousandth of the way; 1 J of triangles, Akima's among them, whose slopes are 0 at
// all points.  The spring has stored its own part where the body ends, at 0.5 + 0.5 v.
std::vector<Bump> bumps() {
  const double bell = std::sqrt(std::numbers::pi);
  return {
      {"bell", joint_force("1000*exp(-((s.position - 0.5)/1e-3)^2)"), bell},
      {"narrow_bell", joint_force("1e6*exp(-((s.position - 0.5)/1e-6)^2)"), bell},
      {"lorentz_sech", joint_force("500/cosh((s.position - 0.5)/1e-3)^2"), 1.0},
      {"beside_a_spring", joint_force("1000*exp(-((s.position - 0.5)/1e-3)^2) - 1e-3*s.position"),
       bell - 0.5e-3 * 1.566 * 1.566},
      {"table", joint_force("bump(s.position)"), 1.0},
      {"measured",
       "[measure.b]\ntype = \"expression\"\nvalue = \"exp(-((s.position - 0.5)/1e-3)^2)\"\n" +
           joint_force("1000*b"),
       bell},
      {"spring_along_a_joint",
       "[force.f]\ntype = \"joint_spring_damper\"\njoint = \"s\"\nrest = -1\ncurve = \"pull\"\n", 1.0},
      {"spring_between_points",
       "[force.f]\ntype = \"spring_damper\"\nfrom = \"ground.B\"\nto = \"m.a\"\ncurve = \"pull\"\n", 1.0}};
}

class PeaksOfForces : public ::testing::TestWithParam<std::tuple<std::size_t, const char*>> {};

TEST_P(PeaksOfForces, DoTheirWholeWork) {
  const auto [index, method] = GetParam();
  const Bump bump = bumps().at(index);
  const Folder folder;
  const std::string set = std::string("solver.method=") + method;
  const double v = last(folder, slider(bump.force), "s.speed", {set});
  // Ten steps or so at 1e-6 over a force that rises to 1e6 N and falls again.
  EXPECT_NEAR(v, std::sqrt(1.0 + 2.0 * bump.work), 1e-4) << bump.name;
}

INSTANTIATE_TEST_SUITE_P(Bumps, PeaksOfForces,
                         ::testing::Combine(::testing::Range(std::size_t{0}, bumps().size()),
                                            ::testing::Values("ida", "radau", "generalised_alpha",
                                                              "runge_kutta")),
                         [](const auto& info) {
                           return std::string(bumps().at(std::get<0>(info.param)).name) + "_" +
                                  std::get<1>(info.param);
                         });

// Two balls of a gram and a radius of a millimetre, one at rest; they meet after a hundred metres.
std::string balls(double speed, double beside) {
  return fmt::format(R"toml(gravity = [0, 0, 0]
[ground.marker.g]
[body.a]
mass = 1e-3
inertia = [1e-9, 1e-9, 1e-9]
marker.o = {{}}
[body.b]
mass = 1e-3
inertia = [1e-9, 1e-9, 1e-9]
marker.o = {{}}
[joint.a]
type = "free"
from = "ground.g"
to = "a.o"
v_x = {}
[joint.b]
type = "free"
from = "ground.g"
to = "b.o"
x = 100
y = {}
[force.c]
type = "contact"
from = "b.o"
to = "a.o"
surface = "sphere"
surface_radius = 0.001
radius = 0.001
stiffness = 1e13
[output]
quantities = ["b.velocity_*"]
[solver]
output_step = 0.1
)toml",
                     speed, beside);
}

class SmallThings : public ::testing::TestWithParam<const char*> {};

TEST_P(SmallThings, HitEachOther) {
  const Folder folder;
  const std::string set = std::string("solver.method=") + GetParam();
  // Equal masses exchange their speeds in a central impact.
  EXPECT_NEAR(last(folder, balls(1000.0, 0.0), "b.velocity_x", {set}), 1000.0, 0.1);
  // With the offset b the line of centres stands at sin(phi) = b / 2 r to the way: the one that stood still leaves along
  // it with v cos(phi).
  const double s = 0.6, c = 0.8;
  EXPECT_NEAR(last(folder, balls(1000.0, s * 0.002), "b.velocity_y", {set}), 1000.0 * c * s, 1.0);
}

TEST_P(SmallThings, MissEachOther) {
  const Folder folder;
  const std::string set = std::string("solver.method=") + GetParam();
  EXPECT_EQ(last(folder, balls(1000.0, 0.002 * (1.0 + 1e-6)), "b.velocity_x", {set}), 0.0);
}

TEST_P(SmallThings, BounceOffAThinWire) {
  const Folder folder;
  const std::string text = R"toml(gravity = [0, 0, 0]
[ground.marker.g]
[body.a]
mass = 1
inertia = [1, 1, 1]
marker.o = {}
[joint.a]
type = "free"
from = "ground.g"
to = "a.o"
x = -3
v_x = 10
[force.c]
type = "contact"
from = "ground.g"
to = "a.o"
radius = 0.001
surface = "cylinder"
surface_radius = 0.001
stiffness = 1e10
[output]
quantities = ["a.velocity_x"]
)toml";
  EXPECT_NEAR(last(folder, text, "a.velocity_x", {std::string("solver.method=") + GetParam()}), -10.0, 1e-2);
}

// 100 N on a path of 1 m for a millisecond of ten seconds: 0.1 N s on 2 kg, whether time or another body says where.
TEST_P(SmallThings, LoadsThatCrossAtOnceAreFelt) {
  const Folder folder;
  const std::string text = R"toml(gravity = [0, 0, 0]
[ground.marker.g]
[ground.marker.x]
axis = [1, 0, 0]
[body.a]
mass = 2
inertia = [1, 1, 1]
marker.o = {}
marker.p = { position = [-0.5, 0, 0] }
marker.m = { position = [0, 0, 0] }
marker.q = { position = [0.5, 0, 0] }
[joint.s]
type = "prismatic"
from = "ground.g"
to = "a.o"
[body.c]
mass = 1
inertia = [1, 1, 1]
marker.o = { axis = [1, 0, 0] }
[joint.v]
type = "prismatic"
from = "ground.x"
to = "c.o"
position = -3
speed = 1000
[force.l]
type = "moving_load"
path = ["a.p", "a.m", "a.q"]
place = "PLACE"
z = -100
[solver]
end_time = 10
output_step = 0.1
)toml";
  for (const std::string place : {"1000*(t - 5)", "v.position"})
    EXPECT_NEAR(
        last(folder, replaced(text, "PLACE", place), "s.speed", {std::string("solver.method=") + GetParam()}),
        -0.05, 1e-8)
        << place;
}

INSTANTIATE_TEST_SUITE_P(Methods, SmallThings,
                         ::testing::Values("ida", "radau", "generalised_alpha", "runge_kutta"));

}  // namespace
}  // namespace flexura::test
