// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/model/mechanism.hpp"

namespace flexura::import::mjcf {

/// The convex hull, triangles counter-clockwise from outside.  Throws std::invalid_argument where the points lie in a plane.
Surface convex_hull(const std::vector<Vector3d>& points);

}  // namespace flexura::import::mjcf
