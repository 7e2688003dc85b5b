// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/file/read_mechanism.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::mbs {

/// A chain of two bodies and one on a guide, in general positions: for an element between "a.out", "b.in" and
/// "ground.track", or of the coordinates "second.angle", "second.position" and "third".
inline constexpr const char* kThreeBodies = R"toml(
[ground.marker.track]
position = [0.1, 0.2, -0.4]
axis = [0.1, 0.2, 1]
[body.a]
mass = 1
inertia = [1, 2, 2.5]
center = [0.1, 0, 0.2]
[body.a.marker.out]
position = [0.3, 0.1, 0.2]
rotation = [0.3, 0.4, 0.5]
[body.b]
mass = 2
inertia = [1, 2, 2.5]
[body.b.marker.in]
position = [0.1, 0.5, -0.2]
axis = [1, 2, 3]
[body.b.marker.hub]
position = [0.1, -0.1, 0.2]
[body.c]
mass = 1
[joint.first]
type = "six_dof"
from = "ground"
to = "a"
[joint.second]
type = "cylindrical"
from = "a.out"
to = "b.hub"
[joint.third]
type = "prismatic"
from = "ground.track"
to = "c"
)toml";

/// An arm with a beam of beam.se.h5 that the load case "wind" acts on.
inline constexpr const char* kBlown = R"toml(
gravity = [0, 0, 0]
[body.arm]
mass = 1
inertia = [0.1, 0.2, 0.3]
[body.arm.marker.end]
position = [0.3, 0.2, 0.1]
[joint.shoulder]
type = "spherical"
from = "ground"
to = "arm"
[body.beam]
superelement = "beam.se.h5"
[joint.elbow]
type = "revolute"
from = "arm.end"
to = "beam.left"
[force.gale]
type = "distributed_load"
body = "beam"
load = "wind"
factor = 2
)toml";

/// Mechanism files written in the test and read without their [solver].
class MechanismFileTest : public test::TestFolder {
 protected:
  MechanismFile read(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    input::TableSchema no_solver;
    no_solver.name = "solver";
    return read_mechanism(file(text), no_solver, overrides);
  }
  std::string refusal(const std::string& text) const {
    return test::refusal_of([&] { read(text); });
  }
};

}  // namespace flexura::mbs
