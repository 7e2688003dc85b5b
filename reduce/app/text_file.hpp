// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

namespace flexura::reduce {

/// Writes beside and renames: the whole text or nothing.  Throws std::runtime_error that names the file where
/// it cannot be written or the disk is full.
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace flexura::reduce
