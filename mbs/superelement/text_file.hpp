// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string_view>

namespace flexura::superelement {

/// Writes beside and renames: the whole content or nothing.  Throws std::runtime_error that names the file
/// where it cannot be written or the disk is full.
void write_whole(const std::filesystem::path& path, std::string_view content);

}  // namespace flexura::superelement
