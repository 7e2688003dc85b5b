// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/input/part.hpp"

/// The skins of shells: what is seen of them, where their stresses are largest, and what carries their rotary inertia.
///
/// At each corner of a cell two points stand half a thickness above and below the middle surface, along the mean
/// normal n of the cells around (of those within 60 degrees: at a fold and where three sheets meet there are more
/// pairs).  They follow the node, u = u_a + theta_a x r.  Masses w on both and -2 w on the point between them have the
/// kinetic energy
///
///     w |theta' x r|^2,   r = n t/2,   w = (sum of rho t^3/12 A/corners) / (t^2/2)
///
/// and no mass (of unlike layers, whose mass centre is off the middle surface, w on one side is more than on the other):
/// exactly the rotary inertia rho t^3/12 of the cells, lumped at the node, with all inertia integrals that
/// go with it.  Cells whose middle surface stands off their nodes have their mass, lumped, on points of that surface.
namespace flexura::reduce {

/// Adds points, followers and masses to the part, fills `skins`, and takes the skins (and walls along free edges)
/// for the shells' share of mesh.boundary.  Does nothing without shells.
void add_shell_skins(Part& part);

}  // namespace flexura::reduce
