// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Mechanisms with the box beam of tests/mbs/superelement, beam.se.h5.

namespace flexura::study::bars {

// A steel bar clamped at one end, shaken at the other.  Clamped, its first bending along y has 38 Hz.
inline const char* const kClamped = R"toml(
gravity = [0, 0, 0]
[parameters]
omega = 150
[ground.marker.wall]
position = [0.3, -0.2, 0.1]
[body.beam]
superelement = "beam.se.h5"
[joint.wall]
type = "fixed"
from = "ground.wall"
to = "beam.left"
[force.tip]
type = "force"
marker = "beam.right"
y = "100 * (1 - cos(omega * t))"
[measure.sway]
type = "position"
from = "ground.wall"
to = "beam.right"
direction = [0, 1, 0]
[output]
quantities = ["sway", "wall.force"]
[solver]
end_time = "0.1 s"
output_step = "0.2 ms"
tolerance = 1e-8
)toml";

// The bar as the rod of a slider-crank that a flywheel carries through five turns.
inline const char* const kTurning = R"toml(
gravity = [0, 0, 0]
[ground.marker.guide]
axis = [1, 0, 0]
[body.crank]
mass = 20
inertia = [0.5, 0.5, 1]
marker.pin = { position = [0.2, 0, 0] }
[body.beam]
superelement = "beam.se.h5"
damping = 0.05
[body.slider]
mass = 5
inertia = [0.01, 0.01, 0.01]
position = [0.9, 0, 0]
marker.slide = { axis = [1, 0, 0] }
[joint.shaft]
type = "revolute"
from = "ground"
to = "crank"
angle = "50 deg"
speed = "20 rad/s"
[joint.crankpin]
type = "revolute"
from = "crank.pin"
to = "beam.left"
[joint.crosshead]
type = "revolute"
from = "slider"
to = "beam.right"
[joint.guide]
type = "prismatic"
from = "ground.guide"
to = "slider.slide"
[output]
quantities = ["shaft.speed", "crankpin.force", "guide.position"]
[solver]
end_time = "1.6 s"
output_step = "2 ms"
method = "radau"
tolerance = 1e-6
)toml";

}  // namespace flexura::study::bars
