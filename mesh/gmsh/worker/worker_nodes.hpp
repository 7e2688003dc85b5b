// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace flexura::mesh {

/// For the child process: gmsh's nodes by tags, numbered from 0 in the order in which cells first name them.  The mesh must
/// not change in its life.
class NodeNumbers {
 public:
  NodeNumbers();

  /// The node's number; where it is new, add(x) gets its three coordinates in gmsh's unit.
  template <class Add>
  std::int64_t of(std::size_t tag, const Add& add) {
    const auto [at, fresh] = number_.emplace(tag, static_cast<std::int64_t>(number_.size()));
    if (fresh) add(&coordinates_[3 * place_.at(tag)]);
    return at->second;
  }

 private:
  std::vector<double> coordinates_;
  std::map<std::size_t, std::size_t> place_;
  std::map<std::size_t, std::int64_t> number_;
};

}  // namespace flexura::mesh
