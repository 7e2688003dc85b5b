// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/part/make_part.hpp"

namespace flexura::reduce {

/// The deck's constraints between nodes, once its interfaces are there: nodes that follow an interface or a spider cannot
/// follow others.  Those that bind the body to the ground are left out with a warning, or, where the input is strict, refused
/// (std::invalid_argument).
void add_equations(const PartInput& input, const PartMesh& from, ModelledPart& out);

}  // namespace flexura::reduce
