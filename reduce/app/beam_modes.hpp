// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iosfwd>

#include "reduce/part/beam_part_input.hpp"

namespace flexura::reduce {

/// The natural frequencies of the free beam structure, nothing reduced, without and with the sections' rotary
/// inertia: `count` elastic modes as a table.
void print_beam_modes(const BeamPartInput& part, int count, std::ostream& out);

}  // namespace flexura::reduce
