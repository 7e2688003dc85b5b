// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/recovery/part_near.hpp"

#include <algorithm>

namespace flexura::reduce {

PartNear cells_at(const Part& part, const std::vector<mesh::Index>& nodes) {
  PartNear near;
  near.part.materials = part.materials;
  near.part.formulation = part.formulation;
  std::vector<char> asked(part.mesh.n_nodes(), 0), used = asked;
  for (const mesh::Index node : nodes) asked[node] = used[node] = 1;
  for (const mesh::CellBlock& block : part.mesh.solids) {
    std::vector<Eigen::Index> rows;
    for (Eigen::Index row = 0; row < block.nodes.rows(); ++row)
      if (std::ranges::any_of(block.nodes.row(row), [&](mesh::Index node) { return asked[node] != 0; })) {
        rows.push_back(row);
        for (const mesh::Index node : block.nodes.row(row)) used[node] = 1;
      }
    if (rows.empty()) continue;
    mesh::CellBlock kept{
        .type = block.type, .variant = block.variant, .nodes = block.nodes(rows, Eigen::all)};
    if (!block.material.empty())
      for (const Eigen::Index row : rows) kept.material.push_back(block.material[row]);
    near.part.mesh.solids.push_back(std::move(kept));
  }
  std::vector<mesh::Index> there(used.size(), -1);
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) {
    if (!used[node]) continue;
    there[node] = static_cast<mesh::Index>(near.nodes.size());
    near.nodes.push_back(node);
  }
  for (mesh::CellBlock& block : near.part.mesh.solids)
    for (mesh::Index& node : block.nodes.reshaped()) node = there[node];
  near.part.mesh.points = part.mesh.points(near.nodes, Eigen::all);
  for (const mesh::Index node : nodes) near.wanted.push_back(there[node]);
  return near;
}

}  // namespace flexura::reduce
