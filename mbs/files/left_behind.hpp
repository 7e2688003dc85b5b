// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string_view>

namespace flexura::files {

/// Removes what killed processes have left under the private names of this output (output.hpp): FILE.part,
/// FILE.PROCESS.part.  Only files that are empty or begin with `opening` are ours; inputs stay.  To be called
/// by the process that has the claim on the output, once it is whole.
void remove_left_behind(const std::filesystem::path& output, std::string_view opening);

}  // namespace flexura::files
