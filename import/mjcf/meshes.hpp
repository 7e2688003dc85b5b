// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/mjcf/model.hpp"
#include "import/tree/inertia.hpp"

namespace flexura::import::mjcf {

/// The surface of a <mesh>, scaled, moved and turned as it says, in metres.  Throws std::invalid_argument, one sentence, where
/// the file is not there, of no known kind, or where it has no triangles.
Surface read_mesh(const Node& mesh, const Model& model);

/// Mass properties for a density as the <mesh> wants them: of the volume, of the shell, of the convex hull; "legacy" adds up the tetrahedra
/// between the facets and their common centre by size, which counts some of a mesh that is not star-shaped twice.
tree::Inertial mesh_inertial(const Surface& surface, const std::string& rule, double density);

}  // namespace flexura::import::mjcf
