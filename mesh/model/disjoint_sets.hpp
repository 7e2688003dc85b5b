// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace flexura::mesh {

/// Things numbered from 0 that are joined step by step; each set is known by its first member (R. E. Tarjan, J. ACM 22
/// (1975) 215, with path halving).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::size_t size() const { return parent_.size(); }
  /// The least member of the set that k is in.
  int of(int k) {
    while (at(k) != k) k = at(k) = at(at(k));
    return k;
  }
  /// Whether they were apart.
  bool join(int a, int b) {
    a = of(a), b = of(b);
    at(std::max(a, b)) = std::min(a, b);
    return a != b;
  }

 private:
  int& at(int k) { return parent_[static_cast<std::size_t>(k)]; }

  std::vector<int> parent_;
};

}  // namespace flexura::mesh
