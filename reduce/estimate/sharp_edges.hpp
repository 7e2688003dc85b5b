// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/assembly/input/part.hpp"

namespace flexura::reduce {

/// Where stresses are unbounded like r^(lambda - 1) at a distance r (M. L. Williams, J. Appl. Mech. 19 (1952) 526).
enum class SharpEdge : char {
  none,
  reentrant,  ///< between faces of the surface that meet at more than 180 degrees: at 270 degrees lambda = 0.545
  held,       ///< around a rigid interface: at a face at right angles lambda = 0.71 for nu = 0.3
  concentrated  ///< the nodes of a concentrated interface (is_concentrated)
};

/// Of the nodes.
std::vector<SharpEdge> sharp_edges(const Part& part);
std::vector<char> nodes_at_sharp_edges(const Part& part);

/// Whether an interface loads elastic solids at a single node or along a straight line, where the displacement of an elastic
/// body under a force is unbounded (Lord Kelvin 1848; like 1/r, or log r): it grows with every finer mesh.
bool is_concentrated(const Part& part, const InterfaceSpec& interface);

}  // namespace flexura::reduce
