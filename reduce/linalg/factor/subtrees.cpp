// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/subtrees.hpp"

#include <algorithm>
#include <numeric>
#include <queue>

namespace flexura::linalg {

SupernodeTree supernode_tree(std::span<const int> first_column, std::span<const int> first_row,
                             std::span<const int> rows) {
  const int n = static_cast<int>(first_column.size()) - 1;
  std::vector<int> supernode_of(first_column[n]);
  for (int s = 0; s < n; ++s)
    std::fill(supernode_of.begin() + first_column[s], supernode_of.begin() + first_column[s + 1], s);
  SupernodeTree tree{std::vector<int>(n, -1), std::vector<int>(n), std::vector<std::vector<int>>(n)};
  std::iota(tree.first_descendant.begin(), tree.first_descendant.end(), 0);
  for (int s = 0; s < n; ++s) {
    const int below = first_row[s] + first_column[s + 1] - first_column[s];
    if (below == first_row[s + 1]) continue;
    const int p = tree.parent[s] = supernode_of[rows[below]];
    tree.children[p].push_back(s);
    tree.first_descendant[p] = std::min(tree.first_descendant[p], tree.first_descendant[s]);
  }
  return tree;
}

Subtrees divide(const SupernodeTree& tree, std::vector<double> work, int n_cores) {
  const int n = static_cast<int>(tree.parent.size());
  const auto smaller = [&work](int a, int b) { return work[a] < work[b]; };
  std::priority_queue<int, std::vector<int>, decltype(smaller)> heap(smaller);
  double total = 0.0;
  for (int s = 0; s < n; ++s)
    if (tree.parent[s] >= 0) work[tree.parent[s]] += work[s];  // of the subtree
  for (int s = 0; s < n; ++s)
    if (tree.parent[s] < 0) heap.push(s), total += work[s];
  Subtrees subtrees;
  const double enough = n_cores == 1 ? total : total / (6.0 * n_cores);
  while (!heap.empty() && work[heap.top()] > enough) {
    const int s = heap.top();
    heap.pop();
    subtrees.top.push_back(s);
    for (const int child : tree.children[s]) heap.push(child);
  }
  for (; !heap.empty(); heap.pop()) subtrees.roots.push_back(heap.top());
  std::sort(subtrees.top.begin(), subtrees.top.end());
  return subtrees;
}

}  // namespace flexura::linalg
