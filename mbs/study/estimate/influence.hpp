// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <set>
#include <string>
#include <vector>

#include "mbs/study/estimate/full_model.hpp"

namespace flexura::study {

/// The bodies of `full` on whose deformation one of the outputs (quantities of `full`) depends, now or until `end` [s].
///
/// A graph with a node for each coordinate and its rate: i depends on j where a deflection or a rate of j alone makes an
/// acceleration of i,
///
///     [M G^T; G 0] (a, lambda) = -[K_j; 0]  or  -[D_j; 0],
///
/// and an output on j where it sees its position, its rate, or what these make of accelerations and multipliers.  So what
/// hangs on a driven joint has no influence on what hangs beside it.  What is asked is whether, not how much: of states
/// and rates drawn at random, twice, so that nothing vanishes by chance, and once more where each function of time in a formula
/// is at work, if only later.  Elements that switch are taken as if they acted.
/// All bodies where formulas have conditions or can be level for a while (max, a table, ...), or controls act, whose other side is not
/// seen.
std::set<std::string> bodies_of_influence(FullModel& full, const mbs::State& start,
                                          const std::vector<int>& outputs, double end);

/// Those of `bodies`, rigid in `run`, on whose deformation no output depends that the file asks for; asked of their lowest
/// modes, which are enough to tell.  None where it asks for none by name.
std::set<std::string> bodies_without_influence(const mbs::PreparedMechanism& run,
                                               std::set<std::string> bodies);

}  // namespace flexura::study
