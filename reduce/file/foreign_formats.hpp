// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace flexura::reduce {

/// What a file of this ending is and the way on that works, "is a modal neutral file of Adams, ...: ...", for files that
/// this program does not read; empty for an ending that it does not know.
std::string foreign_format(const std::filesystem::path& file);

/// The ending in lower case, ".step".
std::string ending_of(const std::filesystem::path& file);

/// True for the endings of CAD files that are read: STEP, IGES, BREP, STL.
bool is_cad_ending(const std::string& ending);

}  // namespace flexura::reduce
