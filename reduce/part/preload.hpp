// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/input/initial_strain.hpp"
#include "reduce/part/part_input.hpp"

namespace flexura::reduce {

/// The strain of the cells that a load of the type preload asks for; those of other materials than its own have none.  Throws
/// std::invalid_argument: a part without solids, an unknown material, a strain that is nowhere or beyond 10 %.
CellStrains preload_strain(const LoadInput& wanted, const Part& part);

}  // namespace flexura::reduce
