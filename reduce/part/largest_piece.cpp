// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/largest_piece.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "mesh/model/disjoint_sets.hpp"
#include "mesh/model/geometry.hpp"
#include "mesh/model/patches.hpp"

namespace flexura::reduce {
namespace {

using mesh::Index;

// The cells whose first node stays.
mesh::CellBlock kept(const mesh::CellBlock& block, const std::vector<char>& stays) {
  std::vector<Eigen::Index> rows;
  for (Eigen::Index row = 0; row < block.nodes.rows(); ++row)
    if (stays[static_cast<std::size_t>(block.nodes(row, 0))]) rows.push_back(row);
  mesh::CellBlock out = block;
  out.nodes = block.nodes(rows, Eigen::all);
  const auto take = [&](auto& to, const auto& from) {
    if (from.empty()) return;
    to.clear();
    for (const Eigen::Index row : rows) to.push_back(from[static_cast<std::size_t>(row)]);
  };
  take(out.label, block.label);
  take(out.material, block.material);
  take(out.thickness, block.thickness);
  take(out.offset, block.offset);
  return out;
}

}  // namespace

void keep_largest_piece(mesh::ImportedModel& model) {
  mesh::Mesh& mesh = model.mesh;
  const auto n = static_cast<std::size_t>(mesh.n_nodes());
  mesh::DisjointSets sets(n);
  std::vector<char> used(n, 0);
  const auto join = [&](Index a, Index b) {
    sets.join(a, b);
    used[static_cast<std::size_t>(a)] = used[static_cast<std::size_t>(b)] = 1;
  };
  for (const auto* blocks : {&mesh.solids, &mesh.shells})
    for (const mesh::CellBlock& block : *blocks)
      for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell)
        for (Eigen::Index a = 0; a < block.nodes.cols(); ++a)
          join(block.nodes(cell, a), block.nodes(cell, 0));
  for (const auto& bar : model.bars) join(bar.nodes[0], bar.nodes[1]);
  for (const auto& spring : model.springs) join(spring.nodes[0], spring.nodes[1]);
  for (const auto& tie : model.ties)
    for (const Index node : tie.nodes) join(node, tie.reference);
  for (const auto& equation : model.equations)
    for (const auto& term : equation.terms) sets.join(term.node, equation.terms.front().node);
  std::map<int, int> sizes;
  for (std::size_t node = 0; node < n; ++node)
    if (used[node]) ++sizes[sets.of(static_cast<int>(node))];
  if (sizes.size() < 2) return;
  const auto largest = std::ranges::max_element(sizes, {}, [](const auto& piece) { return piece.second; });
  std::vector<char> stays(n);
  int left_out = 0;
  for (std::size_t node = 0; node < n; ++node) {
    stays[node] = sets.of(static_cast<int>(node)) == largest->first;
    left_out += used[node] && !stays[node];
  }
  const auto goes = [&](Index node) { return !stays[static_cast<std::size_t>(node)]; };
  for (auto* blocks : {&mesh.solids, &mesh.shells}) {
    for (mesh::CellBlock& block : *blocks) block = kept(block, stays);
    std::erase_if(*blocks, [](const mesh::CellBlock& block) { return block.nodes.rows() == 0; });
  }
  for (auto& [name, set] : mesh.sets) std::erase_if(set.nodes, goes), set.faces.clear();
  std::erase_if(mesh.sets, [](const auto& set) { return set.second.nodes.empty(); });
  mesh.boundary.clear();
  mesh::extract_boundary(mesh);
  mesh::attach_faces_to_sets(mesh);
  std::erase_if(model.bars, [&](const auto& bar) { return goes(bar.nodes[0]); });
  std::erase_if(model.springs, [&](const auto& spring) { return goes(spring.nodes[0]); });
  std::erase_if(model.ties, [&](const auto& tie) { return goes(tie.reference); });
  std::erase_if(model.masses, [&](const auto& mass) { return goes(mass.node); });
  std::erase_if(model.equations, [&](const auto& equation) { return goes(equation.terms.front().node); });
  model.messages.push_back(fmt::format("{} of {} pieces that nothing joins are left out, {} nodes of {}",
                                       sizes.size() - 1, sizes.size(), left_out, left_out + largest->second));
}

}  // namespace flexura::reduce
