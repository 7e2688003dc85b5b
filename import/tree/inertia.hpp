// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/tree/tree.hpp"

namespace flexura::import::tree {

/// Of both, in one frame; of no mass at all the sum of the inertias.
Inertial together(const Inertial& a, const Inertial& b);

/// What a uniform body of this density has in its link's frame; kind surface: of the volume that its triangles enclose.
Inertial uniform(const Solid& solid, double density);

}  // namespace flexura::import::tree
