// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "import/model/mechanism.hpp"

namespace flexura::import::urdf {

/// Triangles of an STL (binary or text), OBJ or COLLADA file, for pictures; vertices that coincide are one.
/// Throws std::invalid_argument, one sentence.
Surface read_surface(const std::filesystem::path& file);

/// Where a URDF's "package://NAME/PATH", "model://...", "$(find NAME)/PATH", "file:///PATH" or path lies.  Packages: those named
/// ("NAME=FOLDER"), else the nearest folder NAME among those above the URDF or beside them, else PATH in one of these folders.
/// Throws std::invalid_argument with the missing file.
std::filesystem::path find_mesh(const std::string& uri, const std::filesystem::path& urdf,
                                const std::vector<std::string>& packages);

}  // namespace flexura::import::urdf
