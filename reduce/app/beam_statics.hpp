// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

#include "reduce/part/beam_part_input.hpp"

namespace flexura::reduce {

/// `flexura reduce --statics`: the load cases of a beam part with the interfaces named in `held` fixed in the
/// directions they keep (none named: all).  Prints the nodes'
/// displacements and, for each member, section forces and the greatest stress at `places` places along it;
/// the same as JSON to `report` unless it is empty.  Throws input::InputError where the part has no loads
/// or no such interface.
void print_statics(const BeamPartInput& part, const std::vector<std::string>& held, int places,
                   std::ostream& out, const std::filesystem::path& report);

}  // namespace flexura::reduce
