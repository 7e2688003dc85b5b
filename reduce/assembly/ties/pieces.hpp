// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "reduce/assembly/input/part.hpp"

/// What of a part hangs together by cells, frames, ties and constraints.
namespace flexura::reduce {

struct Pieces {
  std::vector<int>
      of_node;  ///< from 0; -1 at nodes that nothing stands on, and at points beside beams and shells
  std::vector<int> sizes;  ///< number of nodes of each
};
Pieces pieces_of(const Part& part);

/// The rigid motions of each piece that its interfaces (means of nodes left aside) do not hold, 0 to 6.
std::vector<int> free_motions_of(const Part& part, const Pieces& pieces);

/// Holds each piece that its interfaces leave free: by six displacements of three of its nodes, or, where nodes have
/// rotations, by all six of one.  They become interfaces "piece 2 a", ..., whose names it returns.  Throws
/// std::invalid_argument where the nodes that are left of a piece do not tell its motion.
std::vector<std::string> hold_pieces(Part& part, const Pieces& pieces);

/// Up to three of these nodes that lie far apart and off a line.
std::vector<mesh::Index> spread_nodes(const mesh::Mesh& mesh, const std::vector<mesh::Index>& among);

}  // namespace flexura::reduce
