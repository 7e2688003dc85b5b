// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh/gmsh/job.hpp"

namespace flexura::mesh {

/// The child's side of planar.hpp: arrays.points (third coordinate 0) and, in arrays.integers, six nodes and
/// the region of each triangle.  gmsh must be initialised.
void mesh_planar_faces(const Job& job, ResultRecord& result, Arrays& arrays);

}  // namespace flexura::mesh
