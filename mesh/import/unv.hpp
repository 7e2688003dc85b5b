// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "mesh/import/imported.hpp"

namespace flexura::mesh {

/// Reads an I-DEAS universal file: nodes (dataset 2411), elements (2412: tetrahedra, hexahedra and wedges,
/// linear and parabolic; surface elements serve groups only) and groups (2435, 2452, 2467, 2477), which
/// become sets of their names.  gmsh's own reader crashes on groups of an odd number of members.  Other
/// datasets are named in the messages. Throws std::invalid_argument with file and line.
ImportedModel read_unv(const std::filesystem::path& path);

}  // namespace flexura::mesh
