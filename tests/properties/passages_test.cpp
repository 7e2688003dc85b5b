// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Linkages whose rows depend on each other for an instant move on as their one freedom says: random Scott-Russell linkages and
// rows of parallel cranks, by every integrator, through several such positions.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/mbs/planar_links.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/properties/one_freedom.hpp"

namespace flexura::properties {
namespace {

using mbs::chance::Chance;
using mbs::test::hinge;
using mbs::test::PlanarLink;

constexpr double kTolerances[] = {1e-5, 1e-7, 1e-9};

// A crank a turns about O; a bar 2a carries it at its middle, one end slides along x, the other along z.
TEST(Passages, ScottRussellLinkagesMoveAsTheirOneFreedom) {
  const test::Folder folder;
  for (int seed = 0; seed < 120; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const double a = chance.between(0.1, 2.0), r = chance.between(0.0, a), g = 9.81;
    const double m_crank = chance.between(0.5, 3.0), m_bar = chance.between(0.5, 3.0),
                 m_slider = chance.between(0.5, 3.0), m_top = chance.between(0.5, 3.0),
                 I_crank = chance.between(0.01, 0.1) * a * a, I_bar = chance.between(0.1, 0.5) * a * a;
    // The angle from x down: turns on, or swings through the passage at -90 deg.
    const double angle = chance.between(0.2, 1.3), speed = chance.either_sign(1.0, 3.0) * std::sqrt(g / a);
    const double tolerance = chance.one_of(kTolerances), end = 6.0 * std::sqrt(a / g);
    const std::string method = kMethods[seed % 4];
    const double fixed = I_crank + I_bar + m_crank * r * r + m_bar * a * a;
    const double weight = g * (m_crank * r + m_bar * a + m_top * 2.0 * a);
    const Law law = [&](double q, double w) {
      const double s = std::sin(q), c = std::cos(q), b = 4.0 * a * a;
      // Down is positive: z = -2 a sin q of the top, x = 2 a cos q of the slider.
      const double inertia = fixed + b * (m_slider * s * s + m_top * c * c);
      return (weight * c - b * (m_slider - m_top) * s * c * w * w) / inertia;
    };
    const std::string text = fmt::format(R"(
[ground.marker.P]
axis = [1,0,0]
[ground.marker.V]
axis = [0,0,1]
[ground.marker.O]
axis = [0,1,0]
[body.crank]
mass = {}
center = [{},0,0]
inertia = [1,{},1]
[body.crank.marker.O]
axis = [0,1,0]
[body.crank.marker.M]
position = [{},0,0]
axis = [0,1,0]
[body.bar]
mass = {}
center = [{},0,0]
inertia = [1,{},1]
[body.bar.marker.S]
axis = [0,1,0]
[body.bar.marker.M]
position = [{},0,0]
axis = [0,1,0]
[body.bar.marker.T]
position = [{},0,0]
axis = [0,1,0]
[body.slider]
mass = {}
inertia = [1,1,1]
[body.slider.marker.P]
axis = [1,0,0]
[body.slider.marker.S]
axis = [0,1,0]
[body.top]
mass = {}
inertia = [1,1,1]
[body.top.marker.V]
axis = [0,0,1]
[body.top.marker.T]
axis = [0,1,0]
[joint.slide]
type = "prismatic"
from = "ground.P"
to = "slider.P"
position = {}
[joint.s]
type = "revolute"
from = "slider.S"
to = "bar.S"
angle = {}
[joint.m]
type = "revolute"
from = "crank.M"
to = "bar.M"
[joint.o]
type = "revolute"
from = "ground.O"
to = "crank.O"
angle = {}
speed = {}
[joint.lift]
type = "prismatic"
from = "ground.V"
to = "top.V"
position = {}
[joint.t]
type = "revolute"
from = "bar.T"
to = "top.T"
[solver]
end_time = {}
tolerance = {}
method = "{}"
)",
                                         m_crank, r, I_crank, a, m_bar, a, I_bar, a, 2.0 * a, m_slider, m_top,
                                         2.0 * a * std::cos(angle), std::numbers::pi - angle, angle, speed,
                                         -2.0 * a * std::sin(angle), end, tolerance, method);
    std::string trouble;
    const auto is = run_to_end(folder, text, "o", trouble);
    const std::string which = fmt::format("seed {} by {} to {}\n{}", seed, method, tolerance, text);
    ASSERT_EQ(trouble, "") << which;
    expect_same(is, reference(law, angle, speed, end), tolerance, end, which);
  }
}

// Equal cranks on one line and a coupler on all of them: all rows lose rank where they lie in that line; off the line those
// that were kept do, and others hold. The cranks turn on, parallel.
TEST(Passages, ParallelCranksMoveAsAPendulum) {
  const test::Folder folder;
  for (int seed = 0; seed < 120; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1001);
    const int n = 2 + chance.below(3);
    const bool in_line = n == 2 || chance.flip(0.5);
    const double a = chance.between(0.2, 1.5), g = 9.81, m_coupler = chance.between(0.5, 3.0);
    const double angle = chance.between(0.3, 1.2), speed = chance.either_sign(2.5, 4.0) * std::sqrt(g / a);
    const double tolerance = chance.one_of(kTolerances), end = 4.0 * std::sqrt(a / g);
    const std::string method = kMethods[seed % 4];
    std::string text;
    double inertia = m_coupler * a * a, weight = g * m_coupler * a;
    for (int k = 0; k < n; ++k) {
      const double x = a * (1.3 * k + chance.between(0.0, 0.4)),
                   y = in_line ? 0.0 : a * chance.between(-0.5, 0.5);
      const double m = chance.between(0.5, 2.0), I = m * a * a * chance.between(0.05, 0.15);
      inertia += I + m * 0.25 * a * a;
      weight += g * m * 0.5 * a;
      text += fmt::format(R"(
[ground.marker.g{0}]
position = [{1},{2},0]
[body.crank{0}]
mass = {3}
center = [{4},0,0]
inertia = [1,1,{5}]
[body.crank{0}.marker.end]
position = [{6},0,0]
[body.coupler.marker.c{0}]
position = [{1},{2},0]
[joint.o{0}]
type = "revolute"
from = "ground.g{0}"
to = "crank{0}"
angle = {7}
{8}
[joint.c{0}]
type = "revolute"
from = "crank{0}.end"
to = "coupler.c{0}"
{9}
)",
                          k, x, y, m, 0.5 * a, I, a, angle, k == 0 ? fmt::format("speed = {}", speed) : "",
                          k == 0 ? fmt::format("angle = {}", -angle) : "");
    }
    text =
        fmt::format(
            "gravity = [0,-9.81,0]\n[body.coupler]\nmass = {}\ninertia = [1,1,1]\n[solver]\nend_time = {}\n"
            "tolerance = {}\nmethod = \"{}\"\n",
            m_coupler, end, tolerance, method) +
        text;
    const Law law = [&](double q, double) { return -weight * std::cos(q) / inertia; };
    std::string trouble;
    const auto is = run_to_end(folder, text, "o0", trouble);
    const std::string which = fmt::format("seed {} by {} to {}\n{}", seed, method, tolerance, text);
    ASSERT_EQ(trouble, "") << which;
    expect_same(is, reference(law, angle, speed, end), tolerance, end, which);
  }
}

// A kite (crank as long as coupler, rocker as ground) folds into a line once a turn: beside it one row nearly vanishes, and
// what follows from the others' round-off may be any force. A row that is wrong is told; the crank is driven and the masses are
// small, so that forces stay near those of the inertia, of the order of m a w^2.
TEST(Passages, RowsNextToADeadPointThatAreWrongAreTold) {
  const test::Folder folder;
  int told = 0;
  for (int seed = 0; seed < 16; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const double a = chance.between(0.2, 0.4), w = chance.between(2.0, 4.0), phi = chance.between(0.5, 1.0);
    const double tolerance = chance.one_of(kTolerances);
    const std::string method = kMethods[seed % 4];
    // Tip at the reflection of the crank's pivot over the line from its pin to the rocker's pivot at x = 1.
    const double px = a * std::cos(phi), py = a * std::sin(phi), ux = 1.0 - px, uy = -py,
                 along = -(px * ux + py * uy) / (ux * ux + uy * uy), tx = 2.0 * (px + along * ux),
                 ty = 2.0 * (py + along * uy);
    const double coupler = std::atan2(ty - py, tx - px) - phi, rocker = std::atan2(ty, tx - 1.0);
    const std::string text =
        "gravity = [0, 0, 0]\n[ground.marker.far]\nposition = [1, 0, 0]\n" +
        text_of(PlanarLink{"a", a, 1.0, 0.5 * a, 0.01}) + text_of(PlanarLink{"b", a, 1.0, 0.5 * a, 0.01}) +
        text_of(PlanarLink{"c", 1.0, 1.0, 0.5, 0.01}) +
        hinge("h1", "ground", "a", fmt::format("drive = \"{}+{}*t\"", phi, w)) +
        hinge("h2", "a.t", "b", fmt::format("angle = {:.17g}", coupler)) +
        hinge("h3", "ground.far", "c", fmt::format("angle = {:.17g}", rocker)) +
        hinge("h4", "b.t", "c.t", "cut = true") +
        fmt::format("[solver]\nend_time = {}\noutput_step = 0.0005\ntolerance = {}\nmethod = \"{}\"\n",
                    4.0 * std::numbers::pi / w, tolerance, method);
    mbs::PreparedMechanism p = mbs::prepare(folder.write("kite.toml", text));
    const auto all = p.mechanism->quantities();
    const auto which =
        static_cast<int>(std::ranges::find(all, "h4.force_x", &mbs::OutputInfo::name) - all.begin());
    const auto scratch = p.mechanism->make_scratch();
    double largest = 0.0;
    Eigen::VectorXd value(1);
    const mbs::RunResult result =
        mbs::run(*p.mechanism, p.state, p.v_dot, p.options,
                 {.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
                   p.mechanism->evaluate({which}, s, v_dot, *scratch, value);
                   largest = std::max(largest, std::abs(value(0)));
                 }});
    ASSERT_EQ(result.stopped_because, "") << seed << text;
    told += !result.near_rank_loss.empty();
    // Three masses of 1 kg whose points move on circles: no more than some tens of m w^2.
    if (largest > 50.0 * w * w)
      EXPECT_NE(result.near_rank_loss, "") << seed << ": " << largest << " N\n" << text;
  }
  EXPECT_GT(told, 4);  // the rows hit the places
}

}  // namespace
}  // namespace flexura::properties
