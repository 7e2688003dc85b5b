// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gmsh.h>

#include "mesh/gmsh/job.hpp"

// For the child process: the solids of a CAD file, from the file to what is known of those that are kept.  All throw
// std::runtime_error with a sentence about the file; what was done to a shape goes into result.messages.
namespace flexura::mesh {

/// The solids; faces alone are sewn to one.  What is not closed is refused with the places of its free edges.
gmsh::vectorpair import_solids(const Job& job, ResultRecord& result);

/// Describes all solids and keeps job.solids, or all but those that stand in another's place.
void choose_solids(const Job& job, ResultRecord& result, gmsh::vectorpair& solids);

/// Several solids as one.
void fuse_solids(ResultRecord& result, gmsh::vectorpair& solids);

/// OpenCASCADE's repair of small edges and gaps; says how the volume changed.
void heal_solids(ResultRecord& result, gmsh::vectorpair& solids);

/// Volume, centre, area and faces of the solids that are kept.
void describe_kept(const Job& job, const gmsh::vectorpair& solids, ResultRecord& result);

}  // namespace flexura::mesh
