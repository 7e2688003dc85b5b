// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/mesh.hpp"

namespace flexura::mesh {

Index Mesh::n_solid_cells() const {
  Index n = 0;
  for (const CellBlock& block : solids) n += static_cast<Index>(block.nodes.rows());
  return n;
}

}  // namespace flexura::mesh
