// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/tied_pattern.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace flexura::reduce {
namespace {

// The upper adjacency (self first, ascending) of the vertices that the elements connect.
struct Adjacency {
  std::vector<int> begin{0}, columns;
};

Adjacency upper_adjacency(int n, const std::vector<std::vector<int>>& elements) {
  std::vector<int> begin(n + 1, 0), elements_of;
  for (const auto& element : elements)
    for (int v : element) ++begin[v + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  elements_of.resize(begin[n]);
  std::vector<int> place(begin.begin(), begin.end() - 1);
  for (std::size_t e = 0; e < elements.size(); ++e)
    for (int v : elements[e]) elements_of[place[v]++] = static_cast<int>(e);
  Adjacency graph;
  std::vector<int> mark(n, -1), row;
  for (int v = 0; v < n; ++v) {
    row.assign(1, v);
    mark[v] = v;
    for (int k = begin[v]; k < begin[v + 1]; ++k)
      for (int w : elements[elements_of[k]])
        if (w > v && mark[w] != v) mark[w] = v, row.push_back(w);
    std::sort(row.begin(), row.end());
    graph.columns.insert(graph.columns.end(), row.begin(), row.end());
    graph.begin.push_back(static_cast<int>(graph.columns.size()));
  }
  return graph;
}

}  // namespace

TiedPatterns tied_patterns(const Part& part, const TiedNumbering& numbering) {
  const std::vector<int>& group_begin = numbering.group_begin();
  const int n_groups = static_cast<int>(group_begin.size()) - 1;
  std::vector<std::vector<int>> by_nodes, by_groups;
  const auto connect = [&](std::vector<int> nodes) {
    std::vector<int> groups;
    for (const int node : nodes) numbering.add_groups(node, groups);
    by_nodes.push_back(std::move(nodes));
    by_groups.push_back(std::move(groups));
  };
  if (part.matrices) {
    for (const auto& [a, b] : part.matrices->pairs) connect({a, b});
  } else {
    for (const mesh::CellBlock& block : part.mesh.solids)
      for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell)
        connect({block.nodes.row(cell).begin(), block.nodes.row(cell).end()});
  }
  for (const Link& link : part.links) connect({link.from, link.to});
  for (const mesh::CellBlock& block : part.mesh.shells)
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell)
      connect({block.nodes.row(cell).begin(), block.nodes.row(cell).end()});
  for (const FrameElement& frame : part.frames) connect({frame.nodes.begin(), frame.nodes.end()});
  for (const Follower& follower : part.followers) {
    std::vector<int> groups;
    for (const auto& [node, C] : follower.from) numbering.add_groups(node, groups);
    by_groups.push_back(std::move(groups));
  }
  Adjacency nodes = upper_adjacency(numbering.n_nodes(), by_nodes);
  TiedPatterns out;
  out.m = std::make_unique<linalg::SymmetricMatrix>(std::move(nodes.begin), std::move(nodes.columns));

  const Adjacency groups = upper_adjacency(n_groups, by_groups);
  std::vector<int> begin{0}, columns;
  std::size_t n_entries = 0;
  for (int g = 0; g < n_groups; ++g) {
    std::size_t width = 0;
    for (int k = groups.begin[g]; k < groups.begin[g + 1]; ++k)
      width += group_begin[groups.columns[k] + 1] - group_begin[groups.columns[k]];
    const std::size_t size = group_begin[g + 1] - group_begin[g];
    n_entries += width * size - size * (size - 1) / 2;
  }
  if (n_entries > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw std::runtime_error(
        fmt::format("the stiffness matrix has {} entries, more than 32-bit indices can count: "
                    "use a coarser mesh",
                    n_entries));
  columns.reserve(n_entries);
  for (int g = 0; g < n_groups; ++g)
    for (int i = group_begin[g]; i < group_begin[g + 1]; ++i) {
      for (int k = groups.begin[g]; k < groups.begin[g + 1]; ++k) {
        const int h = groups.columns[k];
        for (int j = std::max(i, group_begin[h]); j < group_begin[h + 1]; ++j) columns.push_back(j);
      }
      begin.push_back(static_cast<int>(columns.size()));
    }
  out.K_ii = std::make_unique<linalg::SymmetricMatrix>(std::move(begin), std::move(columns));
  return out;
}

}  // namespace flexura::reduce
