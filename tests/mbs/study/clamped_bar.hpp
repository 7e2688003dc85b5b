// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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

}  // namespace flexura::study::bars
