// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "reduce/part/part_mesh.hpp"

/// RBE3 (*DISTRIBUTING) that carry elements.  Their reference node has no dofs of its own: where beams, springs and points
/// hang on it, (u, theta) = A u_set is put in its place,
///
///     K -> T^T K T,   C -> C A,
///
/// with the averaging map A (average.hpp), so that they hang on the nodes of the set.  Exact, and rigid motions stay free.
namespace flexura::reduce {

/// Says so of each in `notes`.  Throws std::invalid_argument where the reference node has dofs in solids or shells, where the
/// tie does not give all the directions that the elements hold, and for sets of more than 1000 nodes (the matrix is full).
void spread_averages(const std::vector<DeckTie>& ties, Part& part, std::vector<std::string>& notes);

}  // namespace flexura::reduce
