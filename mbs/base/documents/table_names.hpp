// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace flexura::input {

/// The names of what stands in one table of a TOML file, [interface.NAME], in a file of another program's schema: nothing is checked.
/// Throws InputError where the file is not there or is no TOML.
std::vector<std::string> names_in_table(const std::filesystem::path& file, const std::string& table);

}  // namespace flexura::input
