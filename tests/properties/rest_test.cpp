// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What stands still, and where: masses on springs whose stiffness differs by any power of ten, carriages that drives lead to their
// place, and mechanisms that start as subsystems as they do by themselves.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mbs/solver/start/prepare.hpp"
#include "mbs/solver/statics/equilibrium.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using mbs::chance::Chance;

double position(const mbs::PreparedMechanism& p, const std::string& name) {
  for (int i = 0; i < p.mechanism->sizes().n_p; ++i)
    if (p.mechanism->name_of_position(i) == name) return p.state.p(i);
  throw std::logic_error("no position " + name);
}

// Sliders one on the other along x, a force on the last: each spring stretches by F / k. Without one of them nothing stands still.
TEST(Rest, ChainsOfSpringsOfAnyStiffnessStandWhereTheyBalance) {
  const test::Folder folder;
  for (int seed = 0; seed < 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const int n = 1 + chance.below(4), free = chance.flip(0.3) ? chance.below(n) : -1;
    const double stretch = chance.between(0.1, 1.0);
    const double softest = std::pow(10.0, chance.between(-5.0, 3.0)), F = softest * stretch;
    std::string text = "gravity = [0,0,0]\n[ground.marker.x]\naxis = [1,0,0]\n";
    std::vector<double> k(static_cast<std::size_t>(n));
    const int soft = chance.below(n);
    for (int i = 0; i < n; ++i) {
      k[i] = i == soft ? softest : softest * std::pow(10.0, chance.between(0.0, 23.0));
      text += fmt::format(R"(
[body.b{0}]
mass = {1}
inertia = [1,1,1]
[body.b{0}.marker.x]
axis = [1,0,0]
[joint.j{0}]
type = "prismatic"
from = "{2}.x"
to = "b{0}.x"
)",
                          i, chance.between(0.1, 10.0), i == 0 ? "ground" : fmt::format("b{}", i - 1));
      if (i != free)
        text += fmt::format(
            "[force.s{0}]\ntype = \"joint_spring_damper\"\njoint = \"j{0}\"\nstiffness = {1}\n", i, k[i]);
    }
    text += fmt::format("[force.f]\ntype = \"force\"\nmarker = \"b{}.x\"\nx = {}\n", n - 1, F);
    mbs::PreparedMechanism p = mbs::prepare(folder.write("chain.toml", text));
    if (free >= 0) {
      EXPECT_THROW(mbs::find_equilibrium(*p.mechanism, p.state), std::runtime_error) << seed << text;
      continue;
    }
    ASSERT_NO_THROW(mbs::find_equilibrium(*p.mechanism, p.state)) << seed << text;
    // Newton's last step is a part of 1e-10 of a metre; stretches are of 1e-24 m up to 1 m.
    for (int i = 0; i < n; ++i)
      EXPECT_NEAR(position(p, fmt::format("j{}.position", i)), F / k[i], 1e-9) << seed << text;
  }
}

// A drive that follows the place of its carriage stands where what it asks for is nothing.
TEST(Rest, DrivesThatFollowTheMotionStandWhereTheyAskForNothing) {
  const test::Folder folder;
  for (int seed = 0; seed < 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const double wanted = chance.either_sign(0.1, 2.0), start = chance.either_sign(0.1, 2.0),
                 k = chance.between(2.0, 30.0), d = chance.between(2.0, 10.0);
    const int kind = chance.below(4);
    const std::string drives[] = {
        fmt::format("drive_speed = \"{}*({} - c)\"\n[control.c]\ntype = \"filter\"\ninput = \"j.position\"\n"
                    "time_constant = {}",
                    k, wanted, 1.0 / (8.0 * k)),
        fmt::format("drive_speed = \"{}*({} - j.position)\"", k, wanted),
        fmt::format("drive_speed = \"{}*({:.17g} - sinh(j.position))\"", k, std::sinh(wanted)),
        fmt::format("drive_acceleration = \"{}*({} - j.position) - {}*j.speed\"", k, wanted, d)};
    const std::string text = fmt::format(
        R"(
[ground.marker.m]
axis = [1, 0, {}]
[body.a]
mass = {}
inertia = [0.1, 0.1, 0.1]
[body.a.marker.m]
axis = [1, 0, 0]
[joint.j]
type = "prismatic"
from = "ground.m"
to = "a.m"
position = {}
{}
)",
        chance.between(-1.0, 1.0), chance.between(0.1, 10.0), start, drives[kind]);
    mbs::PreparedMechanism p = mbs::prepare(folder.write("carriage.toml", text));
    ASSERT_NO_THROW(mbs::find_equilibrium(*p.mechanism, p.state)) << seed << text;
    EXPECT_NEAR(position(p, "j.position"), wanted, 1e-9) << seed << text;
  }
}

// A drive of speed whose states come to rest by themselves, or by what hangs on its carriage, does so wherever it stands: it stays.
// Those that go on have no equilibrium.
TEST(Rest, DrivesThatNothingLeadsToAPlaceStayWhereTheyAre) {
  const test::Folder folder;
  for (int seed = 0; seed < 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const double start = chance.either_sign(0.1, 2.0), mass = chance.between(0.2, 3.0),
                 length = chance.between(0.2, 2.0), leans = chance.either_sign(0.1, 1.0),
                 gain = chance.either_sign(0.5, 5.0), lag = chance.between(0.05, 0.5);
    const double goes_on = chance.flip(0.3) ? chance.either_sign(0.1, 1.0) : 0.0;
    const int kind = chance.below(4);
    const std::string drives[] = {
        fmt::format(
            "drive_speed = \"c\"\n[control.c]\ntype = \"filter\"\ninput = \"{}\"\ntime_constant = {}\n",
            goes_on, lag),
        fmt::format(
            "drive_speed = \"{}*c + {}*sin(c)\"\n[control.c]\ntype = \"transfer_function\"\ninput = \"{}\"\n"
            "numerator = [1]\ndenominator = [1, {}, 0.05]\n",
            std::abs(gain), std::abs(gain), goes_on, lag),
        fmt::format("drive_speed = \"c\"\n[control.c]\ntype = \"state\"\nrate = \"{}*(r.angle - {:.17g} + "
                    "{}) - c\"\n",
                    gain, leans, goes_on),
        fmt::format("drive_acceleration = \"{}*(r.angle - {:.17g} + {}) - {}*j.speed\"\n", gain, leans,
                    goes_on, lag)};
    std::string text = fmt::format(
        R"(
[ground.marker.m]
axis = [1, 0, 0]
[body.a]
mass = 1
inertia = [0.1, 0.1, 0.1]
[body.a.marker.m]
axis = [1, 0, 0]
[body.a.marker.p]
axis = [0, 1, 0]
[body.b]
mass = {}
center = [0, 0, {}]
inertia = [0.1, 0.1, 0.1]
[body.b.marker.p]
axis = [0, 1, 0]
[joint.r]
type = "revolute"
from = "a.p"
to = "b.p"
[force.t]
type = "joint_force"
joint = "r"
value = {:.17g}
[joint.j]
type = "prismatic"
from = "ground.m"
to = "a.m"
position = {}
{})",
        mass, -length, mass * 9.81 * length * std::sin(leans), start, drives[kind]);
    text = "gravity = [0, 0, -9.81]\n" + text;
    if (chance.flip(0.5))
      text += fmt::format("[force.s]\ntype = \"joint_spring_damper\"\njoint = \"j\"\nstiffness = {}\n",
                          chance.between(10.0, 1000.0));
    mbs::PreparedMechanism p = mbs::prepare(folder.write("carriage.toml", text));
    if (goes_on != 0.0) {
      EXPECT_THROW(mbs::find_equilibrium(*p.mechanism, p.state), std::runtime_error) << seed << text;
      continue;
    }
    ASSERT_NO_THROW(mbs::find_equilibrium(*p.mechanism, p.state)) << seed << text;
    EXPECT_NEAR(position(p, "j.position"), start, 1e-9) << seed << text;
    EXPECT_NEAR(position(p, "r.angle"), leans, 1e-9) << seed << text;
  }
}

// Nothing is said of the start: joints stand at 0, however their markers are turned, wherever the file is placed.
TEST(Rest, SubsystemsStartAsByThemselves) {
  const test::Folder folder;
  for (int seed = 0; seed < 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const auto three = [&](double size) {
      const Eigen::Vector3d x = chance.vector(size);
      return fmt::format("[{}, {}, {}]", x(0), x(1), x(2));
    };
    const int n = 1 + chance.below(4);
    const char* const types[] = {"revolute", "prismatic", "cylindrical", "spherical", "universal", "fixed"};
    std::string text;
    for (int i = 0; i < n; ++i) {
      const std::string from = i == 0 ? "ground" : fmt::format("b{}", i - 1);
      text += fmt::format(
          "[body.b{0}]\nmass = 1\ninertia = [1,1,1]\n[{1}.marker.to{0}]\nposition = {2}\nrotation = {3}\n"
          "[body.b{0}.marker.at]\nposition = {4}\nrotation = {5}\n[joint.j{0}]\ntype = \"{6}\"\n"
          "from = \"{7}.to{0}\"\nto = \"b{0}.at\"\n",
          i, i == 0 ? from : "body." + from, three(1.0), three(3.0), three(1.0), three(3.0),
          chance.one_of(types), from);
    }
    const std::string place = fmt::format("position = {}\nrotation = {}\n", three(2.0), three(3.0));
    const mbs::PreparedMechanism alone = mbs::prepare(folder.write("part.toml", text));
    const mbs::PreparedMechanism placed =
        mbs::prepare(folder.write("whole.toml", "[subsystem.s]\nfile = \"part.toml\"\n" + place));
    ASSERT_EQ(alone.state.p.size(), placed.state.p.size()) << seed << text << place;
    if (alone.state.p.size() > 0)
      EXPECT_LT((alone.state.p - placed.state.p).lpNorm<Eigen::Infinity>(), 1e-12) << seed << text << place;
  }
}

// Speeds that a coupler forbids are changed by the smallest impulse, v - M^-1 G^T (G M^-1 G^T)^-1 G v, whatever unit its factors
// are in.
TEST(Rest, CouplersOfAnyScaleHoldTheirSpeeds) {
  const test::Folder folder;
  for (int seed = 0; seed < 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const double scale = std::pow(10.0, chance.between(-18.0, 6.0));
    const double a[] = {chance.either_sign(0.3, 3.0), chance.either_sign(0.3, 3.0)};
    const double I[] = {chance.between(0.1, 3.0), chance.between(0.1, 3.0)};
    const double v[] = {chance.either_sign(0.5, 5.0), chance.either_sign(0.5, 5.0)};
    std::string text = fmt::format(
        "gravity = [0,0,0]\n[constraint.c]\ntype = \"coupler\"\njoints = [\"j0\", \"j1\"]\n"
        "factors = [{}, {}]\n",
        a[0] * scale, a[1] * scale);
    for (int i = 0; i < 2; ++i)
      text += fmt::format(
          "[body.b{0}]\nmass = 1\ninertia = [2, 2, {1}]\n[joint.j{0}]\ntype = \"revolute\"\n"
          "from = \"ground\"\nto = \"b{0}\"\nspeed = {2}\n",
          i, I[i], v[i]);
    const mbs::PreparedMechanism p = mbs::prepare(folder.write("coupler.toml", text));
    const double impulse = (a[0] * v[0] + a[1] * v[1]) / (a[0] * a[0] / I[0] + a[1] * a[1] / I[1]);
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(p.state.v(i), v[i] - a[i] * impulse / I[i], 1e-9) << seed << text;
  }
}

// Samples in a row begin with what the one before has begun with.
TEST(Rest, SamplesOfSamplesBeginWithTheirValue) {
  const test::Folder folder;
  for (int seed = 0; seed < 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const int n = 1 + chance.below(5);
    double value = chance.either_sign(0.5, 5.0);
    std::string text = fmt::format(
        "[body.b]\nmass = 1\ninertia = [1,1,1]\n[control.c0]\ntype = \"sample\"\n"
        "input = \"{} + t\"\nperiod = 0.5\n",
        value);
    for (int i = 1; i <= n; ++i) {
      const double factor = chance.either_sign(0.5, 2.0);
      value *= factor;
      text += fmt::format("[control.c{}]\ntype = \"sample\"\ninput = \"{}*c{}\"\nperiod = {}\n", i, factor,
                          i - 1, chance.between(0.1, 1.0));
    }
    const mbs::PreparedMechanism p = mbs::prepare(folder.write("samples.toml", text));
    double is = 0.0;
    for (int i = 0; i < p.mechanism->sizes().n_dyn; ++i)
      if (p.mechanism->name_of_dynamic(i) == fmt::format("c{}.state_1", n)) is = p.state.c(i);
    EXPECT_NEAR(is, value, 1e-12 * std::abs(value)) << seed << text;
  }
}

}  // namespace
}  // namespace flexura::properties
