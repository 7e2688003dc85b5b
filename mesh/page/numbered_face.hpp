// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/view/parts_page.hpp"
#include "mesh/model/face.hpp"

namespace flexura::mesh {

/// A face as the page of parts lists it, with the lines of an [interface] that choose it.
view::NumberedFace numbered_face(const Face& face);

}  // namespace flexura::mesh
