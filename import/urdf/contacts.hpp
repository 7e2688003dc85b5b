// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "import/model/mechanism.hpp"
#include "import/urdf/robot.hpp"

namespace flexura::import::urdf {

/// What stands for a shape where it meets a plane: a ball, in the link's frame.
struct Ball {
  Vector3d center = Vector3d::Zero();
  double radius = 0.0;  ///< 0: a corner
};

/// A sphere itself; of a capsule its ends; of a box its corners; of a cylinder points of its rims, or, of one that is shorter than
/// wide (a wheel), a ball of its radius.  Of meshes none.
std::vector<Ball> balls_of(const Shape& shape);

/// The contacts of all links that can move with the floor, a plane z = const of the world: z = 0, or where the lowest of them stands at
/// the start.  Markers go to the bodies (one for each link, in their order) and the ground.  Gazebo's mu1, kp and kd, or what is said.
void add_floor(const Robot& robot, const std::vector<double>& q, Mechanism& mechanism, Names& names,
               Findings& findings);

}  // namespace flexura::import::urdf
