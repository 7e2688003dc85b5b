// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/library/reduce.hpp"

namespace flexura::reduce {

/// Whether the part's matrices are those of a reduced body: DMIG of Nastran with scalar points among the grid points.
bool is_reduced_body(const PartInput& input);

/// A body that another program has reduced to grid points, its interfaces, and modal coordinates, scalar points: K, M (and D) in these
/// dofs, in which rigid motions move the grid points alone (Craig and Bampton's form, Nastran's KAAX and MAAX).
/// The geometry file has the grid points.  Mass, centre and moments of inertia are those of M for rigid motions; integrals that M
/// does not tell, of the elastic part alone, are as of FlexData without integrals (modal_integrals.hpp), which is said.
/// Interfaces of the part file name grid points; the others are "node 7".  Throws std::invalid_argument for a body that is held, has no
/// mass, or points that the geometry file lacks; input::InputError for keys that go with elements.
Reduced reduce_reduced_body(const PartInput& input);

}  // namespace flexura::reduce
