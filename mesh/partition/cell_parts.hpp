// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mesh/model/mesh.hpp"

namespace flexura::mesh {

/// Cuts the solid cells of a mesh into `n_parts` parts of nearly the same number of cells with little surface
/// between them: METIS' k-way partition of the graph whose edges are faces shared by two cells (G. Karypis,
/// V. Kumar, SIAM J. Sci. Comput. 20 (1998), 359).  One number 0 ... n_parts - 1 for each cell, blocks one
/// after the other; the same every time.  std::runtime_error where METIS fails.
std::vector<int> cell_parts(const Mesh& mesh, int n_parts);

}  // namespace flexura::mesh
