// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/partition/cell_parts.hpp"

#include <metis.h>

#include <stdexcept>

#include "mesh/model/cells/cell.hpp"

namespace flexura::mesh {

std::vector<int> cell_parts(const Mesh& mesh, int n_parts) {
  std::vector<idx_t> begin{0}, nodes;
  for (const CellBlock& block : mesh.solids)
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell) {
      // The corners tell which faces are shared; nodes within edges would only add to the work.
      const auto row = block.nodes.row(cell);
      nodes.insert(nodes.end(), row.begin(), row.begin() + shape_of(block.type).corners);
      begin.push_back(static_cast<idx_t>(nodes.size()));
    }
  idx_t n_cells = static_cast<idx_t>(begin.size()) - 1, n_nodes = mesh.n_nodes();
  std::vector<idx_t> cells(n_cells, 0), of_nodes(n_nodes);
  if (n_cells > n_parts && n_parts > 1) {
    idx_t options[METIS_NOPTIONS], common = 3, parts = n_parts, cut = 0;  // three corners make a face
    METIS_SetDefaultOptions(options);
    options[METIS_OPTION_SEED] = 1;
    if (METIS_PartMeshDual(&n_cells, &n_nodes, begin.data(), nodes.data(), nullptr, nullptr, &common, &parts,
                           nullptr, options, &cut, cells.data(), of_nodes.data()) != METIS_OK)
      throw std::runtime_error("METIS could not cut the mesh into parts");
  }
  return {cells.begin(), cells.end()};
}

}  // namespace flexura::mesh
