// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// Mechanisms of many kinds on which what a run says of itself is held against the truth: trees and loops, hinges and
/// ball joints, light and heavy, with controls, a delay and a force that switches with the motion.
namespace flexura::study::twelve {

struct Mechanism {
  std::string name;
  std::filesystem::path file;  ///< or
  std::string text;            ///< of one
  std::vector<std::string> set;
};

inline const char* const kDoublePendulum = R"toml(gravity = [0, 0, -9.81]
[ground.marker.g]
axis = [0, 1, 0]
[body.a]
mass = 1
center = [0.5, 0, 0]
inertia = [0.01, 0.1, 0.1]
marker.o = { axis = [0, 1, 0] }
marker.e = { position = [1, 0, 0], axis = [0, 1, 0] }
[body.b]
mass = 1
center = [0.5, 0, 0]
inertia = [0.01, 0.1, 0.1]
marker.o = { axis = [0, 1, 0] }
[joint.p]
type = "revolute"
from = "ground.g"
to = "a.o"
angle = "20 deg"
[joint.q]
type = "revolute"
from = "a.e"
to = "b.o"
angle = "-30 deg"
[output]
quantities = ["p.angle", "q.angle", "p.force_*"]
[solver]
end_time = 3
output_step = 0.01
)toml";

inline const char* const kTop = R"toml(gravity = [0, 0, -9.81]
[ground.marker.g]
[body.top]
mass = 1
center = [0, 0, 0.1]
inertia = [0.01, 0.01, 0.002]
marker.o = {}
marker.tip = { position = [0, 0, 0.2] }
[joint.ball]
type = "spherical"
from = "ground.g"
to = "top.o"
qw = 0.9659258262890683
qx = 0.25881904510252074
omega_z = 60
[measure.x]
type = "position"
from = "ground.g"
to = "top.tip"
direction = [1, 0, 0]
[output]
quantities = ["x", "ball.force_*"]
[solver]
end_time = 1
output_step = 0.01
)toml";

inline const char* const kTumbling = R"toml(gravity = [0, 0, 0]
[ground.marker.g]
[body.b]
mass = 1
inertia = [1, 2, 3]
marker.o = {}
marker.e = { position = [1, 0, 0] }
[joint.f]
type = "free"
from = "ground.g"
to = "b.o"
omega_x = 0.01
omega_y = 2
omega_z = 0.02
[measure.x]
type = "position"
from = "ground.g"
to = "b.e"
direction = [1, 0, 0]
[measure.y]
type = "position"
from = "ground.g"
to = "b.e"
direction = [0, 1, 0]
[output]
quantities = ["x", "y"]
[solver]
end_time = 10
output_step = 0.05
)toml";

inline const char* const kSliderCrank = R"toml(gravity = [0, 0, -9.81]
[ground.marker.shaft]
axis = [0, 1, 0]
[ground.marker.guide]
axis = [1, 0, 0]
[body.crank]
mass = 1
center = [0.05, 0, 0]
inertia = [0.001, 0.002, 0.002]
marker.o = { axis = [0, 1, 0] }
marker.pin = { position = [0.1, 0, 0], axis = [0, 1, 0] }
[body.rod]
mass = 0.5
position = [0.1, 0, 0]
center = [0.15, 0, 0]
inertia = [0.0005, 0.004, 0.004]
marker.big = { axis = [0, 1, 0] }
marker.small = { position = [0.3, 0, 0] }
[body.slider]
mass = 0.7
position = [0.4, 0, 0]
inertia = [0.001, 0.001, 0.001]
marker.pin = {}
marker.slide = { axis = [1, 0, 0] }
[joint.main]
type = "revolute"
from = "ground.shaft"
to = "crank.o"
speed = 20
[joint.pin]
type = "revolute"
from = "crank.pin"
to = "rod.big"
[joint.guide]
type = "prismatic"
from = "ground.guide"
to = "slider.slide"
position = 0.4
[joint.wrist]
type = "spherical"
from = "slider.pin"
to = "rod.small"
[force.spring]
type = "joint_spring_damper"
joint = "guide"
coordinate = "position"
stiffness = 300
damping = 0.5
[output]
quantities = ["main.angle", "main.speed", "guide.position", "main.force_x", "main.force_z"]
[solver]
end_time = 1
output_step = 0.01
)toml";

// An arm that its motor holds against its weight.
inline const std::string kArm = R"toml(gravity = [0, 0, -9.81]
[ground.marker.g]
axis = [0, 1, 0]
[body.a]
mass = 1
center = [0.3, 0, 0]
inertia = [0.01, 0.05, 0.05]
marker.o = { axis = [0, 1, 0] }
[joint.p]
type = "revolute"
from = "ground.g"
to = "a.o"
)toml";

inline const std::string kControl = kArm + R"toml([control.pid]
type = "pid"
error = "0.5*sin(3*t) - p.angle"
proportional = 40
integral = 60
derivative = 5
filter_time = "10 ms"
[force.m]
type = "joint_force"
joint = "p"
value = "pid"
[output]
quantities = ["p.angle", "p.speed"]
[solver]
end_time = 3
output_step = 0.01
)toml";

// Dry friction as a formula: the force switches at every turning point, and the run ends before it sticks.
inline const char* const kRelay = R"toml(gravity = [0, 0, 0]
[ground.marker.g]
axis = [1, 0, 0]
[body.a]
mass = 1
inertia = [0.01, 0.01, 0.01]
marker.o = { axis = [1, 0, 0] }
[joint.s]
type = "prismatic"
from = "ground.g"
to = "a.o"
position = 0.3
[force.spring]
type = "joint_spring_damper"
joint = "s"
coordinate = "position"
stiffness = 100
[force.friction]
type = "joint_force"
joint = "s"
value = "s.speed > 0 ? -3 : 3"
[output]
quantities = ["s.position", "s.speed"]
[solver]
end_time = 1.2
output_step = 0.01
)toml";

inline const std::string kDelay = kArm + R"toml([control.late]
type = "delay"
input = "0.5*sin(3*t) - p.angle"
time = "20 ms"
[force.m]
type = "joint_force"
joint = "p"
value = "30*late - 2*p.speed"
[output]
quantities = ["p.angle", "p.speed"]
[solver]
end_time = 3
output_step = 0.01
)toml";

inline std::vector<Mechanism> mechanisms() {
  const std::filesystem::path source = FLEXURA_SOURCE_DIR;
  return {{"pendulum",
           source / "cases/iftomm/a01_pendulum.toml",
           "",
           {"output.quantities=[\"x\", \"y\", \"pivot.angle\"]"}},
          {"double_pendulum", {}, kDoublePendulum, {}},
          {"top", {}, kTop, {}},
          {"tumbling", {}, kTumbling, {}},
          {"slider_crank", {}, kSliderCrank, {}},
          {"control", {}, kControl, {}},
          {"relay", {}, kRelay, {}},
          {"delay", {}, kDelay, {}},
          {"rscr",
           source / "tests/found/rigid/check_integrator_noise.toml",
           "",
           {"output.quantities=[\"l.*\", \"r.*\"]"}},
          {"bricard", source / "cases/iftomm/a04_bricard.toml", "", {"solver.end_time=2"}},
          {"governor", source / "cases/iftomm/a05_governor.toml", "", {"solver.end_time=2"}},
          {"four_bar", source / "docs/tutorials/four_bar/four_bar.toml", "", {}}};
}

}  // namespace flexura::study::twelve
