// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "mbs/base/documents/schema.hpp"
#include "reduce/part/flexdata_input.hpp"

/// Part files of bodies that another program has reduced.
namespace flexura::reduce {

const input::TableSchema& flexdata_schema();

/// A part file with a table [flexdata], or a FlexData file itself (.xml).
bool is_flexdata_file(const std::filesystem::path& file);

/// Throws input::InputError.
FlexDataInput read_flexdata_part(const std::filesystem::path& file,
                                 const std::vector<std::string>& overrides);

}  // namespace flexura::reduce
