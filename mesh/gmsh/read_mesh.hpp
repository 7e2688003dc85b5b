// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mesh/gmsh/job.hpp"

namespace flexura::mesh {

/// Part of the child: opens a mesh file with gmsh and hands over its solid cells and physical groups.
void read_mesh(const std::string& path, ResultRecord& result, Arrays& arrays);

}  // namespace flexura::mesh
