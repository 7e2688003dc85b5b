// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "import/urdf/robot.hpp"

namespace flexura::import::urdf {

/// Finds the root, each link's joint and the order of the joints.  One root, every other link with one parent, no ring; what is not so
/// is a fault.  Links that no joint names beside a root with joints are left out, with a note: they are no part of the robot.
void order_tree(Robot& robot, Findings& findings);

}  // namespace flexura::import::urdf
