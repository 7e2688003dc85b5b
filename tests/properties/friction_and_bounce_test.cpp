// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "tests/app/command.hpp"

/// What is known of friction that creeps at rest, and of contacts that give all back: bounds for random ones.
namespace flexura::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

double draw(std::mt19937& random, double a, double b) {
  return std::uniform_real_distribution<double>(a, b)(random);
}
double draw_power(std::mt19937& random, double a, double b) {
  return std::pow(10.0, draw(random, a, b));
}

constexpr const char* kSlide = R"toml([body.a]
mass = {}
inertia = [1, 1, 1]
[joint.j]
type = "prismatic"
from = "ground"
to = "a"
)toml";

// m v' = T - F tanh(v / v_t) - d v from rest: v rises to where the right side vanishes, with no viscous part v_t artanh(T / F), and
// never beyond.
TEST(Creep, OfSmoothFrictionEndsAtItsFormula) {
  std::mt19937 random(51);  // NOLINT(cert-msc51-cpp): repeatable
  const Folder folder;
  for (int i = 0; i < 200; ++i) {
    const double m = draw_power(random, -1.0, 2.0), F = draw_power(random, -1.0, 3.0),
                 v_t = draw_power(random, -5.0, -2.0), share = draw(random, 0.05, 0.98);
    const double creep = v_t * std::atanh(share);
    // The time constant near the end, m / (F sech^2(v / v_t) / v_t).
    const double tau = m * v_t / (F * (1.0 - share * share)), end = 30.0 * tau;
    const std::string text = "gravity = [0, 0, 0]\n" + fmt::format(fmt::runtime(kSlide), m) +
                             fmt::format(R"toml([force.f]
type = "joint_friction"
joint = "j"
coulomb = {}
transition_speed = {}
[force.load]
type = "joint_force"
joint = "j"
value = {}
)toml",
                                         F, v_t, share * F);
    SCOPED_TRACE(text);
    const mbs::PreparedMechanism p = mbs::prepare(
        folder.write("slide.toml", text), {fmt::format("solver.end_time={}", end), "solver.tolerance=1e-8",
                                           fmt::format("solver.output_step={}", end / 100.0)});
    double fastest = 0.0;
    mbs::RunCallbacks callbacks;
    callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd&, const mbs::EnergyAccount&) {
      fastest = std::max(fastest, s.v(0));
    };
    const mbs::RunResult run = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
    ASSERT_TRUE(run.complete) << run.stopped_because;
    // The tolerance of 1e-8 in each of some steps, of 1e-3 m/s at least; exp(-30) is nothing.
    EXPECT_NEAR(run.state.v(0), creep, 1e-4 * creep);
    EXPECT_LT(fastest, creep * (1.0 + 1e-3));
    EXPECT_LT(run.state.p(0), creep * end * (1.0 + 1e-3));
  }
}

TEST(Creep, IsToldWhereItMovesWhatWouldStick) {
  const Folder folder;
  const auto say = [&](const std::string& type, double load) {
    folder.write("slide.toml",
                 "gravity = [0, 0, 0]\n" + fmt::format(fmt::runtime(kSlide), 1.0) + type +
                     fmt::format("[force.load]\ntype = \"joint_force\"\njoint = \"j\"\nvalue = {}\n", load) +
                     "[solver]\nend_time = 2\n");
    const Outcome outcome = run("flexura", {"simulate", folder / "slide.toml", "-o", folder / "slide.h5"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return outcome.out + outcome.err;
  };
  const std::string
      smooth = "[force.f]\ntype = \"joint_friction\"\njoint = \"j\"\ncoulomb = 10\n",
      sticks = "[force.f]\ntype = \"stick_slip\"\njoint = \"j\"\ncoulomb = 10\nstick_stiffness = 1e6\n";
  // 1 mm/s artanh(0.9) = 1.47 mm/s, for 2 s.
  EXPECT_THAT(say(smooth, 9.0), AllOf(HasSubstr("friction \"f\" creeps where it would stick: 0.0029 m"),
                                      HasSubstr("0.0015 m/s"), HasSubstr("stick_slip")));
  EXPECT_THAT(say(smooth, 0.0), Not(HasSubstr("creeps")));
  EXPECT_THAT(say(smooth, 12.0), Not(HasSubstr("creeps")));  // it slides
  EXPECT_THAT(say(sticks, 9.0), Not(HasSubstr("creeps")));
}

// A foot on the floor, pushed with 0.8 of what friction holds.
TEST(Creep, OfAContactIsToldToo) {
  const Folder folder;
  folder.write("foot.toml", R"toml([body.a]
mass = 1
inertia = [1, 1, 1]
position = [0, 0, 0.1]
[body.a.marker.c]
[ground.marker.o]
[joint.j]
type = "planar"
from = "ground.side"
to = "a.side"
[ground.marker.side]
axis = [0, 1, 0]
[body.a.marker.side]
axis = [0, 1, 0]
[force.floor]
type = "contact"
from = "ground.o"
to = "a.c"
radius = 0.1
stiffness = 1e6
damping = 1e3
friction = 0.5
[force.push]
type = "force"
marker = "a.c"
x = "0.8*0.5*9.81"
[force.upright]
type = "joint_spring_damper"
joint = "j"
coordinate = "angle"
stiffness = 1e5
damping = 100
[solver]
end_time = 1
)toml");
  const Outcome outcome = run("flexura", {"simulate", folder / "foot.toml", "-o", folder / "foot.h5"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out + outcome.err,
              AllOf(HasSubstr("friction \"floor\" creeps where it would stick: 0.0011 m"),
                    HasSubstr("transition_speed")));
}

// A ball falls on a floor that gives all back.  What its energy gains or loses in an impact goes with the tolerance as the errors
// of the method do, and is what the balance of energy is open by.
TEST(Bounce, OfARestitutionOfOneGainsWhatTheToleranceAllows) {
  std::mt19937 random(52);  // NOLINT(cert-msc51-cpp): repeatable
  const Folder folder;
  // Three times what these 200 need at most: the steps of an impact, each within its tolerance, add up.
  const std::pair<const char*, double> methods[] = {
      {"ida", 6.0}, {"radau", 25.0}, {"runge_kutta", 400.0}, {"generalised_alpha", 1.0}};
  for (int i = 0; i < 200; ++i) {
    const double m = draw_power(random, -2.0, 2.0), height = draw_power(random, -1.0, 1.0),
                 stiffness = m * draw_power(random, 4.0, 7.0), tolerance = draw_power(random, -9.0, -5.0),
                 exponent = i % 2 == 0 ? 1.0 : 1.5, g = 9.81;
    const std::string text =
        fmt::format(fmt::runtime(kSlide), m) + fmt::format(R"toml(position = {}
[force.floor]
type = "contact"
from = "ground"
to = "a"
radius = 0.05
stiffness = {}
exponent = {}
restitution = 1
)toml",
                                                           height + 0.05, stiffness, exponent);
    const auto& [method, most] = methods[i % 4];
    SCOPED_TRACE(fmt::format("{}: {} at {}\n{}", i, method, tolerance, text));
    const mbs::PreparedMechanism p =
        mbs::prepare(folder.write("ball.toml", text),
                     {fmt::format("solver.end_time={}", 20.0 * std::sqrt(2.0 * height / g)),
                      std::string("solver.method=") + method, fmt::format("solver.tolerance={}", tolerance),
                      fmt::format("solver.output_step={}", 0.1 * std::sqrt(height / g))});
    double impacts = 0.0;
    bool fell = false;
    double gain = 0.0, balance = 0.0;
    const double E = m * g * height;
    mbs::RunCallbacks callbacks;
    callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd&, const mbs::EnergyAccount& account) {
      const double z = s.p(0) - 0.05, v = s.v(0);
      if (v < 0.0) fell = true;
      if (fell && v > 0.0) {
        ++impacts;
        fell = false;
      }
      if (z < 0.0) return;
      gain = std::max(gain, std::abs(m * g * z + 0.5 * m * v * v - E) / E);
      balance = std::max(balance, std::abs(m * g * z + 0.5 * m * v * v - E - account.error()) / E);
    };
    const mbs::RunResult run = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
    ASSERT_TRUE(run.complete) << run.stopped_because;
    ASSERT_GT(impacts, 5.0);
    EXPECT_LT(gain, impacts * most * std::pow(tolerance, mbs::kind_of(method).power_of_tolerance));
    // Nothing is lost and nothing put in: the balance is open by just that.
    EXPECT_LT(balance, 1e-9);
  }
}

}  // namespace
}  // namespace flexura::test
