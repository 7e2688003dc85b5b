// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "import/model/findings.hpp"
#include "import/model/folder.hpp"

namespace flexura::import::urdf {

/// Every edge lies between two triangles that turn alike.
bool is_closed(const Surface& surface);

/// Vertices that coincide to 1e-5 of the size become one: CAD kernels give every face its own, within their tolerance.
void weld(Surface& surface);

/// For each body whose surface is closed and in one piece: parts/NAME.stl (binary, m, frame B) and a part file of it, from
/// which it can be made flexible, of the material that is nearest by density.  Adds a note that names the others.
std::vector<TextFile> link_parts(const Mechanism& mechanism, Findings& findings);

}  // namespace flexura::import::urdf
