// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gmsh.h>

#include "mesh/gmsh/job.hpp"

// For the child process: a closed surface of triangles (an STL file) as the boundary of a solid.
namespace flexura::mesh {

/// Cuts the surface into faces at its sharp edges and gives them and the solid inside to gmsh, which meshes them anew; fills
/// result's solid, faces, volume, area and centroid.  Several closed surfaces are one outside and the cavities in it.  Throws
/// std::runtime_error with a sentence about the file: edges of one triangle or of more than two (with their places), several
/// bodies, no volume.
gmsh::vectorpair import_surface(const Job& job, ResultRecord& result);

}  // namespace flexura::mesh
