// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/gmsh/cad.hpp"
#include "mesh/model/mesh.hpp"

namespace flexura::mesh {

struct MeshFile {
  Mesh mesh;  ///< numbers as in the file, which has no unit; physical groups are sets, with node and cell
              ///< labels
  std::vector<std::string> messages;
};

enum class MeshFileCells { solids, shells };

/// Reads gmsh's own meshes, .msh of versions 2 and 4 (text and binary), with all solid cells and all physical
/// groups (unnamed ones are called "group 7").  gmsh runs in the child process. Throws std::invalid_argument
/// for files that are missing, empty, no such mesh, or without solid cells.  As shells, which have no thickness yet, the triangles
/// and quadrilaterals of three and four nodes are taken; solid cells beside them are refused.
MeshFile read_mesh_file(const std::filesystem::path& path, const std::filesystem::path& worker = {},
                        double time_limit_s = 600, MeshFileCells cells = MeshFileCells::solids);

}  // namespace flexura::mesh
