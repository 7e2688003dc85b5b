// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "import/app/robot.hpp"

namespace flexura::import {

enum class TreeFormat { mjcf, sdf };

/// By the ending (.mjcf, .sdf, .world), of .xml by the outermost element.  Nothing where it is neither.
std::optional<TreeFormat> tree_format(const std::filesystem::path& file);

struct TreeChoices {
  std::optional<bool> floating_base;  ///< of an SDF; without it as the file says
  bool stops = true;
  std::vector<std::string> packages = {};
};

/// Reads an MJCF or SDF, and tries the mechanism.  Throws std::invalid_argument (Faults among them) and std::runtime_error.
ReadRobot read_tree(const std::filesystem::path& file, TreeFormat format, const TreeChoices& choices,
                    bool strict);

}  // namespace flexura::import
