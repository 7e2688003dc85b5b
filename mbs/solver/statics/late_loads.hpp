// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/mechanism/mechanism.hpp"

/// Loads that are not there yet: what is made at one instant, as a buckling factor, counts nothing of a load that
/// begins, or grows from zero, later.
namespace flexura::mbs {

/// One sentence where forces do nothing in the state `s` and act, in the same positions, at a later time up to `end_time`;
/// else "".
std::string late_loads(const Mechanism& mechanism, const State& s, double end_time);

}  // namespace flexura::mbs
