// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mesh/import/imported.hpp"
#include "reduce/assembly/input/part.hpp"

/// Beams, rods and springs of a deck among its solids and shells.
///
/// A beam's stiffness is that of SIMBEAM's element (beam/element).  Its mass is that of 4 places along it, each a point on
/// the axis and two pairs beside it, which move by the element's shape functions: exactly its consistent mass with
/// rotary inertia where those are cubic, with all inertia integrals that go with it.
namespace flexura::reduce {

/// Adds elements, points, masses and what is seen (the outline of the cross-section; where it is not known, bars of a
/// rectangular one with the same radii of gyration, which have no stresses) to a part that has its mesh and materials.  Throws std::invalid_argument that names the element.
void add_bars(const std::vector<mesh::ImportedBar>& bars, Part& part);
void add_springs(const std::vector<mesh::ImportedSpring>& springs, Part& part);

}  // namespace flexura::reduce
