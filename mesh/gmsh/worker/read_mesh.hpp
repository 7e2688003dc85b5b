// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mesh/gmsh/job.hpp"

namespace flexura::mesh {

/// Part of the child: gmsh's mesh format by gmsh.  Throws std::runtime_error for what does not begin as one.
void merge_msh(const std::string& path);

/// Part of the child: reads a mesh file with gmsh and hands over its cells (dimension 3: solids, 2: shells) and physical groups.
void read_mesh(const std::string& path, int dimension_wanted, ResultRecord& result, Arrays& arrays);

}  // namespace flexura::mesh
