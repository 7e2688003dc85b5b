// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/cms/result/options.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/linalg/petsc/team.hpp"

/// A reduction by all ranks of a team: each assembles its piece of the mesh (assembly/shared_assembly.hpp), factors and
/// vectors lie on all of them, and all go through the same stages.  Rank 0 alone knows the whole mesh; it is given shapes at
/// the nodes of the surface, the small matrices, and once the factor is gone the judged motions on all nodes.
namespace flexura::reduce {

/// On rank 0 of options.team; `part` is `whole` with its elastic ties rigid.
Reduction lead_reduction(const Part& whole, const Part& part, const ReductionOptions& options);

/// What the ranks that do not lead do until rank 0 sends them home.
void serve(const linalg::Team& team);

}  // namespace flexura::reduce
