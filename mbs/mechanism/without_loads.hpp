// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/mechanism/residual.hpp"

namespace flexura::mbs {

/// A mechanism without what it carries: weight, given forces, the given part of elements that also respond.
Unloaded without_loads(const MechanismParts& m, const Residual& residual, const State& s,
                       MechanismScratch& work);

/// The largest number of what each force does in a state.
std::vector<double> sizes_of_forces(const MechanismParts& m, const Residual& residual, const State& s,
                                    MechanismScratch& work);

}  // namespace flexura::mbs
