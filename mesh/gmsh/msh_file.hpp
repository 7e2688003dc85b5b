// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

namespace flexura::mesh {

/// Whether the file begins with the mark of gmsh's mesh format, at its first byte: gmsh runs whatever begins otherwise as a
/// script.
bool begins_as_msh(const std::filesystem::path& file);

/// Refuses (std::invalid_argument) what is missing, empty, no file or no mesh of gmsh's.
void inspect_msh_file(const std::filesystem::path& path);

}  // namespace flexura::mesh
