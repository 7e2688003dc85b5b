// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/input/part.hpp"

/// The strain that the material of a preloaded part would take if its cells were free: of a bolt that is tightened, a ring that
/// is shrunk on, a wire that is too short, of heat.  The stress is D (strain - initial strain).
namespace flexura::reduce {

/// n_cells x 6, the solids in the order of their blocks, constant in each: xx, yy, zz, and xy, yz, zx as angles.
using CellStrains = Eigen::Matrix<double, Eigen::Dynamic, 6, Eigen::RowMajor>;

/// n_nodes x 3 [N], integral of B^T D e dV: what the strain does to the nodes.  Forces without resultant.
Eigen::MatrixX3d initial_strain_forces(const Part& part, const CellStrains& strain);

}  // namespace flexura::reduce
