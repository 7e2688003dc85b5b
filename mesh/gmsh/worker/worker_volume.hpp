// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gmsh.h>

#include "mesh/gmsh/job.hpp"

// For the child process: tetrahedra in solids.
namespace flexura::mesh {

/// Meshes edges, faces and the volume with the job's sizes, coarser where there would be more than it allows; what
/// sizes were taken is in the result.
void generate_mesh(const Job& job, ResultRecord& result);

/// The mesh of the solids and of result.faces, in m, without nodes of which no tetrahedron is made.
Arrays collect_mesh(const Job& job, const gmsh::vectorpair& solids, const ResultRecord& result);

}  // namespace flexura::mesh
