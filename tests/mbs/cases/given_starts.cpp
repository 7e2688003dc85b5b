// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <numbers>
#include <random>

#include "mbs/solver/statics/equilibrium.hpp"
#include "tests/mbs/cases/text_case.hpp"

/// Starts from what is given: values that fit stay, and of speeds that do not only those are named; equilibria where
/// friction sticks and forces read reactions.
namespace flexura::mbs::cases {
namespace {

using Eigen::VectorXd;
using std::numbers::pi;

class GivenStarts : public TextCase {
 protected:
  std::mt19937 source_{1};
  double in(double from, double to) { return std::uniform_real_distribution<double>(from, to)(source_); }
};

// Scott Russell's straight line: crank r, a bar of 2 r held at its middle, its ends on two lines across. What is given of
// slide = 2 r cos(a), o = a, lift = -2 r sin(a) fits, and stays, wherever the others begin: slide and o were "moved to close
// the loops", from 0.7 to -0.2 m.
TEST_F(GivenStarts, ValuesThatFitStayWhereTheyAre) {
  for (int sample = 0; sample < 200; ++sample) {
    const double r = in(0.2, 2.0), a = in(-1.4, 1.4);
    const int given = std::uniform_int_distribution<int>(1, 7)(source_);
    const double exact[] = {2 * r * std::cos(a), a, -2 * r * std::sin(a)};
    const auto value = [&](int bit, const char* key) {
      return (given >> bit) & 1 ? fmt::format("{} = {:.17g}\n", key, exact[bit]) : std::string();
    };
    const std::string text = fmt::format(
        "[ground.marker.O]\naxis = [0, 1, 0]\n[ground.marker.P]\naxis = [1, 0, 0]\n"
        "[body.crank]\nmass = 1\ninertia = [1e-2, 1e-2, 1e-2]\n[body.crank.marker.O]\naxis = [0, 1, 0]\n"
        "[body.crank.marker.M]\nposition = [{0}, 0, 0]\naxis = [0, 1, 0]\n"
        "[body.bar]\nmass = 2\ncenter = [{0}, 0, 0]\ninertia = [1e-2, 0.1, 0.1]\n[body.bar.marker.S]\naxis = "
        "[0, 1, 0]\n"
        "[body.bar.marker.M]\nposition = [{0}, 0, 0]\naxis = [0, 1, 0]\n[body.bar.marker.T]\nposition = "
        "[{1}, 0, 0]\n"
        "axis = [0, 1, 0]\n[body.slider]\nmass = 1\ninertia = [1e-3, 1e-3, "
        "1e-3]\n[body.slider.marker.P]\naxis = [1, 0, 0]\n"
        "[body.slider.marker.S]\naxis = [0, 1, 0]\n[body.top]\nmass = 3\ninertia = [1e-3, 1e-3, 1e-3]\n"
        "[body.top.marker.T]\naxis = [0, 1, 0]\n"
        "[joint.slide]\ntype = \"prismatic\"\nfrom = \"ground.P\"\nto = \"slider.P\"\n{2}"
        "[joint.s]\ntype = \"revolute\"\nfrom = \"slider.S\"\nto = \"bar.S\"\n"
        "[joint.m]\ntype = \"revolute\"\nfrom = \"crank.M\"\nto = \"bar.M\"\n"
        "[joint.o]\ntype = \"revolute\"\nfrom = \"ground.O\"\nto = \"crank.O\"\n{3}"
        "[joint.lift]\ntype = \"prismatic\"\nfrom = \"ground\"\nto = \"top\"\n{4}"
        "[joint.t]\ntype = \"revolute\"\nfrom = \"bar.T\"\nto = \"top.T\"\n",
        r, 2 * r, value(0, "position"), value(1, "angle"), value(2, "position"));
    SCOPED_TRACE(fmt::format("{}: r {} a {} given {}", sample, r, a, given));
    const PreparedMechanism p = prepared(text);
    const VectorXd found = now(p, {"slide.position", "o.angle", "lift.position"});
    for (int bit = 0; bit < 3; ++bit)
      if ((given >> bit) & 1) EXPECT_NEAR(found(bit), exact[bit], 1e-8 * (1.0 + r)) << bit;
    for (const std::string& note : p.notes) EXPECT_EQ(note.find("were moved"), std::string::npos) << note;
  }
}

// A block on a spring, pushed by a part of the reaction that carries it and a second block, on which that one sticks: the spring
// is pressed by f + c (m_0 + m_1) g, and what sticks holds nothing. None was found (alone either was).
TEST_F(GivenStarts, FrictionSticksWhereAForceReadsAReaction) {
  for (int sample = 0; sample < 200; ++sample) {
    const double m_0 = in(0.1, 5), m_1 = in(0.1, 5), k = in(50, 500), k_1 = in(10, 100), f = in(-5, 5),
                 c = in(-0.5, 0.5), x_1 = in(-0.2, 0.2);
    const std::string text = fmt::format(
        "gravity = [0, 0, -9.81]\n[ground.marker.P]\naxis = [1, 0, 0]\n"
        "[body.b0]\nmass = {}\ninertia = [1, 1, 1]\n[body.b0.marker.P]\naxis = [1, 0, 0]\n"
        "[body.b1]\nmass = {}\ninertia = [1, 1, 1]\n[body.b1.marker.P]\naxis = [1, 0, 0]\n"
        "[joint.j0]\ntype = \"prismatic\"\nfrom = \"ground.P\"\nto = \"b0.P\"\n"
        "[joint.j1]\ntype = \"prismatic\"\nfrom = \"b0.P\"\nto = \"b1.P\"\n"
        "[force.k0]\ntype = \"joint_spring_damper\"\njoint = \"j0\"\nstiffness = {}\n"
        "[force.k1]\ntype = \"joint_spring_damper\"\njoint = \"j1\"\nstiffness = {}\nrest = {}\n"
        "[measure.carried]\ntype = \"load_cell\"\njoint = \"j0\"\naxes = \"ground\"\ndirection = [0, 0, 1]\n"
        "[force.push]\ntype = \"joint_force\"\njoint = \"j0\"\nvalue = \"{} + {} * abs(carried)\"\n"
        "[force.rub]\ntype = \"stick_slip\"\njoint = \"j1\"\ncoulomb = 5\nstatic = 8\nstick_stiffness = "
        "2000\n"
        "stick_damping = 30\n",
        m_0, m_1, k, k_1, x_1, f, c);
    SCOPED_TRACE(text);
    PreparedMechanism p = prepared(text);
    ASSERT_NO_THROW(find_equilibrium(*p.mechanism, p.state));
    const VectorXd found = now(p, {"j0.position", "j1.position"});
    EXPECT_NEAR(found(0), (f + c * (m_0 + m_1) * 9.81) / k, 1e-9);
    // The spring of what sticks, 2 kN/m, gives way; past the limit of 8 N it slides and sticks again.
    const double held = k_1 * x_1 / (k_1 + 2000.0);
    if (std::abs(2000.0 * held) < 8.0)
      EXPECT_NEAR(found(1), held, 1e-9);
    else
      EXPECT_LE(std::abs(k_1 * (x_1 - found(1))), 8.0 * (1.0 + 1e-9));
  }
}

// Speeds that a drive contradicts are changed alone, and named alone, where all that it does not see can stay.
TEST_F(GivenStarts, OfSpeedsThatContradictADriveItsOwnIsChanged) {
  const std::filesystem::path text = file(
      "gravity = [0, 0, 0]\n[ground.marker.P]\naxis = [1, 0, 0]\n[body.frame]\nmass = 10\ninertia = [1, 1, "
      "1]\n"
      "[body.frame.marker.P]\naxis = [1, 0, 0]\n[body.hub]\nmass = 1\ncenter = [0, 0.2, 0]\ninertia = [0.1, "
      "0.1, 0.1]\n"
      "[joint.rail]\ntype = \"prismatic\"\nfrom = \"ground.P\"\nto = \"frame.P\"\n"
      "[joint.turn]\ntype = \"revolute\"\nfrom = \"frame\"\nto = \"hub\"\ndrive = \"2 * t\"\n");
  const std::filesystem::path state = file(
      "{\"format\": \"flexura state\", \"version\": 1, \"velocities\": {\"rail.speed\": 0.5, \"turn.speed\": "
      "0}}",
      "state.json");
  const PreparedMechanism p = prepare(text, {}, state);
  const VectorXd v = now(p, {"rail.speed", "turn.speed"});
  EXPECT_DOUBLE_EQ(v(0), 0.5);
  EXPECT_DOUBLE_EQ(v(1), 2.0);
  bool is_told = false;
  for (const std::string& note : p.notes)
    if (note.find("initial velocities") != std::string::npos) {
      is_told = true;
      EXPECT_NE(note.find("\"turn.speed\" contradict"), std::string::npos) << note;
      EXPECT_EQ(note.find("rail"), std::string::npos) << note;
    }
  EXPECT_TRUE(is_told);
}

}  // namespace
}  // namespace flexura::mbs::cases
