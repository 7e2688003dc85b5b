// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace flexura::import::sdf {

/// Where "model://NAME/PATH", "package://NAME/PATH", "file:///PATH" or a path lies: NAME as `packages` say ("NAME=FOLDER"), else the nearest
/// folder NAME at, beside or above the file.  Empty where there is nothing.
std::filesystem::path find_uri(const std::string& uri, const std::filesystem::path& file,
                               const std::vector<std::string>& packages);

/// The SDF of a model's folder: the newest version that its model.config names, else model.sdf; a file stays itself.  Empty where there is none.
std::filesystem::path model_file(const std::filesystem::path& folder);

}  // namespace flexura::import::sdf
