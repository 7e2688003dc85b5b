// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh/gmsh/job.hpp"

// For the child process: the faces of a CAD file as the middle surface of a sheet.
namespace flexura::mesh {

/// Reads the faces, joins them where they meet, describes them and, where job.size > 0, meshes them: quadrilaterals and a few
/// triangles, or (surface_algorithm 1) triangles.  integers: for each block its cells' face numbers, then their nodes.  Throws
/// std::runtime_error with a sentence about the file.
void mesh_sheet(const Job& job, ResultRecord& result, Arrays& arrays);

}  // namespace flexura::mesh
