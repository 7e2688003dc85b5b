// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/superelement/superelement.hpp"

namespace flexura::view {

/// The undeformed surface as it is seen along (-1, -1, -1), z up, as an SVG element: shaded triangles with hidden ones hidden
/// (a picture that a z-buffer draws here, so that the page's size depends on its pixels and not on the mesh), feature edges, a
/// dot and the name at each interface, and the length of the part.  Empty where the file holds no surface.
std::string part_drawing(const superelement::Superelement& se);

/// The bytes of a PNG of width x height pixels, 4 bytes each (red, green, blue, opacity), from the top left row by row.
std::string png_of(const std::string& rgba, int width, int height);

}  // namespace flexura::view
