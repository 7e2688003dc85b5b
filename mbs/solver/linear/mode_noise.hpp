// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/solver/linear/linearise.hpp"

/// The round-off of the highest modes lies on the lowest: where sections are 1e10 times stiffer than the bending of a thin
/// beam nothing may be left of its first frequencies.
namespace flexura::mbs {

/// One sentence where a vibration is right to less than three digits (NaturalMode::noise), or what is given as zero may be
/// one; else "".
std::string lost_in_round_off(const std::vector<NaturalMode>& modes);

}  // namespace flexura::mbs
