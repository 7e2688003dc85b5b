// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "import/cad/contacts.hpp"

namespace flexura::import::cad {

/// The instance that stands still: the one called `wanted`, by its own name or by that in `names`; the one with the largest box where none
/// is named.  Throws std::invalid_argument where the name is none's, or of several.
int find_ground(const Assembly& assembly, const std::vector<PlacedPart>& parts,
                const std::vector<std::string>& names, const std::string& wanted);

}  // namespace flexura::import::cad
