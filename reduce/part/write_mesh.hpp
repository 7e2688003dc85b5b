// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mesh/model/mesh.hpp"
#include "reduce/elements/material.hpp"

/// The mesh that a part is reduced from, for checks in other programs: nodes, solid and shell cells, sets; in .inp also materials
/// and sections.  In m, kg, s.
namespace flexura::reduce {

/// By the file's ending: Abaqus (.inp), ParaView (.vtu, ASCII), gmsh 2.2 (.msh, ASCII).  std::invalid_argument for
/// another ending or a mesh without cells; std::runtime_error when the file system refuses.
void write_mesh(const std::filesystem::path& path, const mesh::Mesh& mesh,
                const std::vector<Material>& materials);

/// Whether write_mesh knows the ending.
bool is_mesh_ending(const std::filesystem::path& path);

}  // namespace flexura::reduce
