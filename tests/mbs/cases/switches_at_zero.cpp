// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>

#include "mbs/solver/statics/statics.hpp"
#include "tests/mbs/cases/text_case.hpp"

/// Switches that begin at their zero, meet it in pairs, or come back to it at once, with every integrator.
/// Motions are smooth between switches: at the tolerance below they follow their exact solutions to a
/// thousandth of their amplitudes, or a hundred times better, where a switch that is missed or taken twice
/// changes them by more than the amplitude itself.
namespace flexura::mbs::cases {
namespace {

class SwitchesAtZero : public TextCase, public ::testing::WithParamInterface<const char*> {
 protected:
  std::vector<std::string> with_method(std::vector<std::string> overrides) const {
    overrides.push_back(fmt::format("solver.method={}", GetParam()));
    overrides.push_back("solver.tolerance=1e-9");
    return overrides;
  }
  PreparedMechanism ball(std::vector<std::string> overrides) const {
    overrides.push_back("solver.end_time=0.2");
    return prepare_case("switches/bouncing_ball.toml", with_method(std::move(overrides)));
  }
  // A wheel of 0.5 kg m^2 about its axle.
  PreparedMechanism turning(const std::string& more, double end_time) const {
    return prepare(
        file(wheel + more + fmt::format("[solver]\nend_time = {}\noutput_step = 0.01\n", end_time)),
        with_method({}));
  }
  // As it went, or as it ended before its time.
  static RunResult result(const PreparedMechanism& p) {
    return run(*p.mechanism, p.state, p.v_dot, p.options);
  }
};

constexpr double g = 9.81, omega = 100.0;  // of the ball of 1 kg on its floor of 1e4 N/m

// How far a spring is pressed in at t after a steady force set in that holds it `deep` in the end: with x'' +
// 2 a x' + omega_0^2 x = omega_0^2 deep from rest.
double pressed(double t, double deep, double a, double omega_0) {
  const double w = std::sqrt(omega_0 * omega_0 - a * a);
  return deep * (1.0 - std::exp(-a * t) * (std::cos(w * t) + a / w * std::sin(w * t)));
}

TEST_P(SwitchesAtZero, BallPutDownOnTheFloorSinksInAsFarAsItsWeightAsks) {
  const PreparedMechanism p = ball({"joint.fall.position=0.05"});
  const Series s = simulate(p, {"fall.position"});
  const double deep = g / (omega * omega);
  for (std::size_t i = 0; i < s.t.size(); ++i)
    EXPECT_NEAR(s.values[i](0) - 0.05, -pressed(s.t[i], deep, 0.0, omega), 1e-3 * deep) << s.t[i];
}

TEST_P(SwitchesAtZero, DampedBallPutDownOnTheFloorComesToRest) {
  const PreparedMechanism p = ball({"joint.fall.position=0.05", "force.floor.damping=40"});
  const Series s = simulate(p, {"fall.position"});
  const double deep = g / (omega * omega);
  for (std::size_t i = 0; i < s.t.size(); ++i)
    EXPECT_NEAR(s.values[i](0) - 0.05, -pressed(s.t[i], deep, 20.0, omega), 1e-3 * deep) << s.t[i];
}

TEST_P(SwitchesAtZero, BallThatTouchesWithoutLoadFeelsTheFloorOncePressed) {
  // The gap is 0 to the bit until the force sets in: F = -c (t - t_0).
  const PreparedMechanism p = prepare(file(R"toml(
gravity = [0, 0, 0]
[body.ball]
mass = 1
inertia = [1, 1, 1]
[joint.fall]
type = "prismatic"
from = "ground"
to = "ball"
position = 0.05
[force.floor]
type = "contact"
from = "ground"
to = "ball"
radius = "50 mm"
stiffness = "10 kN/m"
[force.press]
type = "joint_force"
joint = "fall"
value = "-200*max(0, t - 0.05)"
[solver]
end_time = 0.2
output_step = 0.005
)toml"),
                                      with_method({"solver.max_step=0.01"}));
  const Series s = simulate(p, {"fall.position"});
  const double c = 200.0 / (omega * omega);
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double t = std::max(0.0, s.t[i] - 0.05);
    // The kink of the force costs what one step across it may.
    EXPECT_NEAR(s.values[i](0) - 0.05, -c * (t - std::sin(omega * t) / omega), 1e-3 * c * 0.15) << t;
  }
}

TEST_P(SwitchesAtZero, TeethWithoutPlayHandOverFromFlankToFlank) {
  // Both gaps pass their zeros at the same instants; together the flanks are one spring.
  const PreparedMechanism p =
      prepare_case("switches/backlash.toml", with_method({"force.teeth.backlash=0 m"}));
  const Series s = simulate(p, {"teeth.position"});
  const double r_1 = 0.05, r_2 = 0.08, v = 3.0 * r_1;
  const double w = std::sqrt(1e6 * (r_1 * r_1 / 2e-3 + r_2 * r_2 / 8e-3));
  for (std::size_t i = 0; i < s.t.size(); ++i)
    EXPECT_NEAR(s.values[i](0), v / w * std::sin(w * s.t[i]), 1e-3 * v / w) << s.t[i];
}

TEST_P(SwitchesAtZero, JointOnItsStopTakesTheTorqueAtOnce) {
  const PreparedMechanism p = turning(R"toml(
[force.stop]
type = "bump_stop"
joint = "axle"
upper = 0
stiffness = 5e3
damping = 20
[force.push]
type = "joint_force"
joint = "axle"
value = "10"
)toml",
                                      0.2);
  const Series s = simulate(p, {"axle.angle"});
  // 0.5 x'' + 20 x' + 5e3 x = 10.
  const double deep = 10.0 / 5e3;
  for (std::size_t i = 0; i < s.t.size(); ++i)
    EXPECT_NEAR(s.values[i](0), pressed(s.t[i], deep, 20.0, 100.0), 1e-3 * deep) << s.t[i];
}

TEST_P(SwitchesAtZero, RelayAtItsLevelSwitchesOnceForEveryPassage) {
  // sin(2 pi t) begins at the relay's level and passes it at every half second; the relay has no hysteresis.
  const PreparedMechanism p = turning(R"toml(speed = 0
[control.sign]
type = "relay"
input = "sin(2*pi*t)"
[force.turn]
type = "joint_force"
joint = "axle"
value = "sign"
)toml",
                                      2.25);
  const Series s = simulate(p, {"sign"});
  ASSERT_EQ(s.result.events.size(), 5u);  // 0, 0.5, ..., 2
  for (std::size_t k = 0; k < 5; ++k) EXPECT_NEAR(s.result.events[k].t, 0.5 * static_cast<double>(k), 1e-9);
}

TEST_P(SwitchesAtZero, RelayThatTurnsItsInputBackEndsTheRunByItsName) {
  // 0.5 w' = -sign(w): at rest after 0.5 s, where either position of the relay asks for the other.
  const PreparedMechanism p = turning(R"toml(speed = 1
[control.sign]
type = "relay"
input = "axle.speed"
starts_on = true
off = -1
[force.brake]
type = "joint_force"
joint = "axle"
value = "-sign"
)toml",
                                      2.0);
  const RunResult r = result(p);
  EXPECT_FALSE(r.complete);
  EXPECT_NE(r.stopped_because.find("\"sign.level\" switches without end at t = 0.5"), std::string::npos)
      << r.stopped_because;
  EXPECT_NE(r.stopped_because.find("hysteresis"), std::string::npos);
}

TEST_P(SwitchesAtZero, BlockThatTurnsRoundSticksForAnInstantOnly) {
  // Thrown against a force that friction cannot hold: v falls with (F + F_c) / m to 0 and goes on with (F -
  // F_c) / m.
  const PreparedMechanism p = turning(R"toml(speed = 1
[force.friction]
type = "stick_slip"
joint = "axle"
static = 3
coulomb = 2
stribeck_speed = 0
stick_stiffness = 1e6
[force.push]
type = "joint_force"
joint = "axle"
value = "-5"
)toml",
                                      0.5);
  const Series s = simulate(p, {"axle.speed"});
  const double turns = 0.5 * 1.0 / 7.0;
  ASSERT_EQ(s.result.events.size(), 2u) << "caught, broken away";
  EXPECT_NEAR(s.result.events[0].t, turns, 1e-8);
  // It yields for as long as 5 N m take to move 0.5 kg m^2 by less than 5 N m / 1e6 N m: sqrt(4 * 0.5 / 1e6).
  EXPECT_LT(s.result.events[1].t - turns, 1.5e-3);
  EXPECT_NEAR(s.values.back()(0), -(5.0 - 2.0) / 0.5 * (0.5 - turns), 6.0 * 1.5e-3);
}

TEST_P(SwitchesAtZero, ManyBallsThatLandAtOneInstantAreNoEndlessSwitching) {
  std::string text = "gravity = [0, 0, -9.81]\n";
  for (int k = 1; k <= 30; ++k)
    text += fmt::format(
        "[body.ball_{0}]\nmass = 1\ninertia = [1, 1, 1]\n[joint.fall_{0}]\ntype = \"prismatic\"\nfrom = "
        "\"ground\"\nto = \"ball_{0}\"\nposition = 0.1\n[force.floor_{0}]\ntype = \"contact\"\nfrom = "
        "\"ground\"\nto = \"ball_{0}\"\nradius = 0\nstiffness = 1e4\n",
        k);
  const PreparedMechanism p =
      prepare(file(text + "[solver]\nend_time = 0.2\noutput_step = 0.01\n"), with_method({}));
  const RunResult r = result(p);
  EXPECT_TRUE(r.complete) << r.stopped_because;
  EXPECT_EQ(r.events.size(), 60u);
}

TEST_P(SwitchesAtZero, TeethThatGrazeEachOtherGoTheirWayAfterAFewSwitchings) {
  // The pair of cases/rattle with a torsion spring for its shaft: of a hundred depths of the oscillation one (ida), twenty
  // (radau), fifty and nearly all (runge_kutta) lead to flanks that touch, or let go, at hardly any speed, where the gap and the push
  // are round-off. Each of the two switches has twenty switchings before it is given a hysteresis, which ends them.
  const std::string text = file(R"toml(gravity = [0, 0, 0]
[parameters]
depth = 1.5
[body.wheel_1]
mass = 1
inertia = [6e-4, 6e-4, 1.15e-3]
[body.wheel_2]
mass = 1.5
inertia = [1.2e-3, 1.2e-3, 2e-3]
[joint.first]
type = "revolute"
from = "ground"
to = "wheel_1"
speed = 100
[joint.second]
type = "revolute"
from = "ground"
to = "wheel_2"
angle = "0.499e-4 / 0.08"
speed = "-62.5"
[force.shaft]
type = "joint_force"
joint = "first"
value = "-4228*(first.angle - 100*t - depth*0.0324*step(t, 0, 0, 0.08, 1)*sin(157.08*t)) - 0.13*(first.speed - 100)"
[force.teeth]
type = "gear_mesh"
joint_1 = "first"
joint_2 = "second"
radius_1 = 0.05
radius_2 = 0.08
backlash = 1e-4
stiffness = 2e7
damping = 200
[force.drag]
type = "joint_force"
joint = "second"
value = "step(t, 0, 0, 0.04, 1)"
[solver]
end_time = 0.3
output_step = 0.01
)toml");
  for (int k = 0; k < 20; ++k) {
    const PreparedMechanism p =
        prepare(text, {fmt::format("solver.method={}", GetParam()), "solver.tolerance=1e-5",
                       fmt::format("parameters.depth={}", 1.2 + 0.01 * k)});
    const RunResult r = result(p);
    EXPECT_TRUE(r.complete) << r.stopped_because;
    std::size_t most = 0;
    for (std::size_t i = 0, first = 0; i < r.events.size(); ++i) {
      while (r.events[i].t - r.events[first].t > 1e-11) ++first;
      most = std::max(most, i - first + 1);
    }
    EXPECT_LE(most, 50u) << "at depth " << 1.2 + 0.01 * k;
  }
}

TEST(SwitchesInStatics, BallFallsToTheFloorAndSinksInAsFarAsItsWeightAsks) {
  // From 1 m above it, from its surface and from inside: N = k delta^n = m g.
  for (const double height : {1.05, 0.05, 0.03})
    for (const double n : {1.0, 1.5})
      for (const char* loss : {"damping=40", "restitution=0.5"}) {
        PreparedMechanism p =
            prepare_case("switches/bouncing_ball.toml",
                         {fmt::format("joint.fall.position={}", height), fmt::format("force.floor.{}", loss),
                          fmt::format("force.floor.exponent={}", n)});
        solve_statics(*p.mechanism, p.state);
        // Newton's last step is below 1e-9 of the metre.
        EXPECT_NEAR(now(p, {"fall.position"})(0), 0.05 - std::pow(g / 1e4, 1.0 / n), 1e-8)
            << height << " " << n;
      }
}

INSTANTIATE_TEST_SUITE_P(Integrators, SwitchesAtZero,
                         ::testing::Values("ida", "radau", "generalised_alpha", "runge_kutta"),
                         [](const auto& info) { return info.param; });

}  // namespace
}  // namespace flexura::mbs::cases
