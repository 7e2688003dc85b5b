// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/statics/statics.hpp"

namespace flexura::mbs {

/// solve_statics() of a mechanism.  Where loops close only by bending ANCF beams, these start undeformed with
/// the loops open and the loops close by steps, in equilibrium at each: a slack cable sags then, where
/// closing at once would crush it, and it could come to rest folded.  Beams that this does not bring to rest
/// get weight and given forces by steps, too.  Throws what solve_statics() throws.
StaticsReport find_equilibrium(const Mechanism& mechanism, State& s);

}  // namespace flexura::mbs
