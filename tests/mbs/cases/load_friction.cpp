// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/mbs/cases/text_case.hpp"

/// Forces and controls that read reactions and accelerations: friction that follows its load, against closed solutions.
namespace flexura::mbs::cases {
namespace {

using ::testing::HasSubstr;

const std::string methods[] = {"ida", "radau", "runge_kutta", "generalised_alpha"};

class LoadFriction : public TextCase, public ::testing::WithParamInterface<std::string> {
 protected:
  std::string solver(double end, double step) const {
    return fmt::format("[solver]\nend_time = {}\noutput_step = {}\nmethod = \"{}\"\ntolerance = 1e-9\n", end,
                       step, GetParam());
  }
};

// A block of 3 kg on a plane at 30 degrees, x downhill, pressed on it by its weight alone.
const std::string incline = R"toml(
gravity = [4.905, 0, -8.495709211125343]
[ground.marker.g]
axis = [1, 0, 0]
[body.block]
mass = 3
inertia = [0.1, 0.1, 0.1]
[body.block.marker.s]
axis = [1, 0, 0]
[joint.plane]
type = "prismatic"
from = "ground.g"
to = "block.s"
speed = 1
[measure.pressed]
type = "load_cell"
joint = "plane"
axes = "ground"
direction = [0, 0, 1]
[force.friction]
type = "joint_force"
joint = "plane"
value = "-0.2*abs(pressed)*tanh(plane.speed/1e-3)"
)toml";

TEST_P(LoadFriction, OnAnInclineIsCoulombs) {
  const PreparedMechanism p = prepared(incline + solver(1, 0.1));
  const Series s =
      simulate(p, {"plane.position", "plane.speed", "pressed", "friction.force", "plane.force_y"});
  const double N = 3 * 8.495709211125343, a = 4.905 - 0.2 * 8.495709211125343;
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    EXPECT_NEAR(s.values[i](2), N, 1e-9);
    EXPECT_NEAR(s.values[i](3), -0.2 * N, 1e-9);
    EXPECT_NEAR(s.values[i](1), 1 + a * s.t[i], 1e-6);
    EXPECT_NEAR(s.values[i](0), s.t[i] + 0.5 * a * s.t[i] * s.t[i], 1e-6);
  }
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-5);
}

// A bead on a turning rod presses sideways by Coriolis' force, which its own friction changes: with omega constant
//   r'' = omega^2 r - mu sign(r') 2 omega |r'|  without weight:  r'' + 2 mu omega r' - omega^2 r = 0.
TEST_P(LoadFriction, OfABeadOnATurningRodFollowsCoriolisForce) {
  const double omega = 2, mu = 0.3;
  const PreparedMechanism p = prepared(R"toml(
gravity = [0, 0, 0]
[ground.marker.g]
[body.rod]
mass = 1
inertia = [1, 1, 1]
[body.rod.marker.hub]
[body.rod.marker.way]
axis = [1, 0, 0]
[body.bead]
mass = 0.7
inertia = [1e-6, 1e-6, 1e-6]
[body.bead.marker.s]
axis = [1, 0, 0]
[joint.hub]
type = "revolute"
from = "ground.g"
to = "rod.hub"
drive = "2*t"
[joint.way]
type = "prismatic"
from = "rod.way"
to = "bead.s"
position = 0.1
speed = 0.1
[measure.side]
type = "load_cell"
joint = "way"
axes = "rod"
direction = [0, 1, 0]
[force.friction]
type = "joint_force"
joint = "way"
value = "-0.3*side*tanh(way.speed/1e-9)"
)toml" + solver(1, 0.1));
  const Series s = simulate(p, {"way.position", "way.speed", "side"});
  const double root = std::sqrt(mu * mu + 1), l1 = omega * (-mu + root), l2 = omega * (-mu - root);
  const double c1 = (0.1 - 0.1 * l2) / (l1 - l2), c2 = 0.1 - c1;
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    const double t = s.t[i], r = c1 * std::exp(l1 * t) + c2 * std::exp(l2 * t),
                 v = c1 * l1 * std::exp(l1 * t) + c2 * l2 * std::exp(l2 * t);
    EXPECT_NEAR(s.values[i](0), r, 2e-6) << t;
    EXPECT_NEAR(s.values[i](1), v, 1e-5) << t;
    EXPECT_NEAR(s.values[i](2), 0.7 * 2 * omega * s.values[i](1), 1e-8) << t;
  }
}

// Friction is mu times the sum of the weight and of a share k of the block's own inertia force, which it changes itself:
// m a = F - mu (m g + k m a).
TEST_P(LoadFriction, ThatFollowsTheAccelerationItMakesIsSolvedInTheStep) {
  const PreparedMechanism p = prepared(R"toml(
gravity = [0, 0, -9.81]
[ground.marker.g]
axis = [1, 0, 0]
[body.block]
mass = 2
inertia = [0.1, 0.1, 0.1]
[body.block.marker.s]
axis = [1, 0, 0]
[joint.way]
type = "prismatic"
from = "ground.g"
to = "block.s"
speed = 1
[measure.a]
type = "acceleration"
from = "ground"
to = "block"
direction = [1, 0, 0]
[measure.pressed]
type = "load_cell"
joint = "way"
axes = "ground"
direction = [0, 0, 1]
[force.pull]
type = "joint_force"
joint = "way"
value = "30*cos(3*t)"
[force.friction]
type = "joint_force"
joint = "way"
value = "-0.25*(pressed + 0.8*2*a)"
)toml" + solver(1, 0.1));
  const Series s = simulate(p, {"way.speed", "a", "pressed"});
  const double mass = 2 * (1 + 0.25 * 0.8);
  for (std::size_t i = 0; i < s.t.size(); ++i) {
    EXPECT_NEAR(s.values[i](1), (30 * std::cos(3 * s.t[i]) - 0.25 * 2 * 9.81) / mass, 1e-9);
    EXPECT_NEAR(s.values[i](0), 1 + (10 * std::sin(3 * s.t[i]) - 0.25 * 2 * 9.81 * s.t[i]) / mass, 1e-6);
  }
}

TEST_P(LoadFriction, ADriveAnswersToTheForceOnIt) {
  // Admittance: the drive's acceleration is a tenth of the force that a spring of 40 N/m puts on the cart, read in the
  // joint that drives it: x'' = -(40 x) / 10 whatever the cart weighs.
  const PreparedMechanism p = prepared(R"toml(
gravity = [0, 0, 0]
[ground.marker.g]
axis = [1, 0, 0]
[body.cart]
mass = 5
inertia = [1, 1, 1]
[body.cart.marker.s]
axis = [1, 0, 0]
[body.tool]
mass = 1e-6
inertia = [1e-6, 1e-6, 1e-6]
[body.tool.marker.s]
axis = [1, 0, 0]
[joint.rail]
type = "prismatic"
from = "ground.g"
to = "cart.s"
speed = 0.3
drive_acceleration = "felt/10"
[joint.sensor]
type = "fixed"
from = "cart.s"
to = "tool.s"
[measure.felt]
type = "load_cell"
joint = "sensor"
axes = "ground"
direction = [-1, 0, 0]
[force.wall]
type = "force"
marker = "tool"
x = "-40*rail.position"
)toml" + solver(2, 0.1));
  const Series s = simulate(p, {"rail.position", "felt"});
  for (std::size_t i = 0; i < s.t.size(); ++i)
    EXPECT_NEAR(s.values[i](0), 0.15 * std::sin(2 * s.t[i]), 2e-6) << s.t[i];
}

INSTANTIATE_TEST_SUITE_P(By, LoadFriction, ::testing::ValuesIn(methods),
                         [](const auto& info) { return info.param; });

class LoadFrictionFiles : public TextCase {};

TEST_F(LoadFrictionFiles, WithoutASolutionIsSaid) {
  // m a = F - (-m a) has no acceleration.
  const std::string text = R"toml(
gravity = [0, 0, 0]
[body.m]
mass = 2
inertia = [1, 1, 1]
[joint.s]
type = "prismatic"
from = "ground"
to = "m"
[measure.a]
type = "acceleration"
from = "ground"
to = "m"
direction = [0, 0, 1]
[force.f]
type = "joint_force"
joint = "s"
value = "1 + 2*a"
)toml" + solver;
  std::string said;
  try {
    prepared(text);
  } catch (const std::exception& error) {
    said = error.what();
  }
  EXPECT_THAT(
      said,
      HasSubstr("what reads \"a\" changes it in turn so that accelerations and reactions cannot be solved"));
}

TEST_F(LoadFrictionFiles, ControlsAndFormulasReadThemToo) {
  // A filter of an acceleration that is constant.
  const PreparedMechanism p = prepared(incline + R"toml([measure.a]
type = "acceleration"
from = "ground"
to = "block"
direction = [1, 0, 0]
[measure.share]
type = "expression"
value = "a/9.81"
[control.smooth]
type = "filter"
input = "share"
time_constant = 0.2
)toml" + solver);
  const Series s = simulate(p, {"smooth"});
  const double a = 4.905 - 0.2 * 8.495709211125343;
  for (std::size_t i = 0; i < s.t.size(); ++i)
    EXPECT_NEAR(s.values[i](0), a / 9.81 * (1 - std::exp(-s.t[i] / 0.2)), 1e-7);
}

}  // namespace
}  // namespace flexura::mbs::cases
