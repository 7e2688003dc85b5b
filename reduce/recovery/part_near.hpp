// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/assembly/input/part.hpp"

namespace flexura::reduce {

/// The solids of a part that have some of its nodes, as a part of their own.
struct PartNear {
  Part part;
  std::vector<mesh::Index> nodes;   ///< of each of its nodes the number in the whole part, ascending
  std::vector<mesh::Index> wanted;  ///< the nodes that were asked for, by their numbers here
};

PartNear cells_at(const Part& part, const std::vector<mesh::Index>& nodes);

}  // namespace flexura::reduce
