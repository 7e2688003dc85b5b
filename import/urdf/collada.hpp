// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "import/urdf/surface_builder.hpp"

namespace flexura::import::urdf {

/// Triangles of a COLLADA document (Khronos, COLLADA 1.4.1): triangles, polylists, polygons, strips and fans, where its scene
/// places them, in metres by the document's unit.  Its up_axis is not followed, as by the programs of ROS.  Throws
/// std::invalid_argument by builder.refuse.
void read_collada(const std::filesystem::path& file, const std::string& text, SurfaceBuilder& builder);

}  // namespace flexura::import::urdf
