// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string_view>
#include <vector>

namespace flexura::files {

/// Is `name` one of the private names of an output `file`: FILE.part, FILE.4711.part, FILE.4711-2.part?
bool is_private_name(std::string_view name, std::string_view file);

/// The files beside an output that have its private names and are empty or begin with `opening`; with "" the
/// empty ones.  `place` as of place_of().
std::vector<std::filesystem::path> private_files(const std::filesystem::path& place,
                                                 std::string_view opening);

/// Removes what killed processes have left under the private names of this output (output.hpp): FILE.part,
/// FILE.PROCESS.part.  Only files that are empty or begin with `opening` are ours; inputs stay.  To be called
/// by the process that has the claim on the output, once it is whole.
void remove_left_behind(const std::filesystem::path& output, std::string_view opening);

}  // namespace flexura::files
