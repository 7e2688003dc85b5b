// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh/gmsh/job.hpp"

namespace flexura::mesh {

/// Part of the child: curves of a CAD file or gmsh model as straight pieces (curves.hpp).  integers: first
/// point, second point and curve of each piece (their number is that of the only block), then the curves of
/// each group.
void collect_curves(const Job& job, ResultRecord& result, Arrays& arrays);

}  // namespace flexura::mesh
