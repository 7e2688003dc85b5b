// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "reduce/assembly/input/part.hpp"

/// An interface for what the others do not hold.
///
/// Fixed-interface modes want all six rigid motions held by the interfaces together.  Where they are not (supports
/// in one direction, a free body), the mean motion of the body itself is a coordinate as well: an averaging tie
/// over all nodes that no interface has, weighted by their share of the volume, at their mean position.  It stiffens
/// nothing, and with no other interface the modes are those that leave the mean motion zero.
namespace flexura::reduce {

/// How many of the six rigid motions the interfaces leave free.
int free_rigid_motions(const Part& part);

/// Adds the interface, called "body" (or "whole_body" where that name is taken), where it is wanted; returns its
/// name, or an empty text.  std::invalid_argument where the interfaces have all nodes.
std::string hold_whole_body(Part& part);

}  // namespace flexura::reduce
