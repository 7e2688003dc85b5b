// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/tree/tree.hpp"

namespace flexura::import::tree {

/// Solids as the mechanism file's own shapes where it has them; others (boxes that are turned, ellipsoids, meshes) as triangles of the body's
/// surface where it has mass, which only then can carry one.  Returns how many could not be drawn.
int draw(const std::vector<Solid>& solids, Body& body);

/// The same without a surface.
int draw(const std::vector<Solid>& solids, std::vector<std::vector<Line>>& shapes);

}  // namespace flexura::import::tree
