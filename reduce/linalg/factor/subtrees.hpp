// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

namespace flexura::linalg {

/// The elimination tree of supernodes in postorder: the subtree of s is first_descendant[s] ... s; parent -1 at a root.
struct SupernodeTree {
  std::vector<int> parent, first_descendant;
  std::vector<std::vector<int>> children;
};

/// Of supernodes that are stored like those of SupernodalFactor.
SupernodeTree supernode_tree(std::span<const int> first_column, std::span<const int> first_row,
                             std::span<const int> rows);

/// Subtrees that cores work through side by side, and the supernodes above them, which all cores share.
struct Subtrees {
  std::vector<int> roots;  ///< the one with most work first
  std::vector<int> top;    ///< ascending
};

/// Subtrees small enough to be shared out evenly; all of the tree for one core.  `work` is that of each supernode.
Subtrees divide(const SupernodeTree& tree, std::vector<double> work, int n_cores);

}  // namespace flexura::linalg
