// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "import/model/folder.hpp"
#include "import/urdf/convert.hpp"

namespace flexura::import {

struct ReadRobot {
  Mechanism mechanism;
  std::vector<TextFile> texts;  ///< part files of links that can be made flexible
  Findings findings;
};

/// Reads a URDF, or a template that xacro expands (`trusted`: whatever is in it), as `choices` say, and tries the mechanism.  Throws
/// std::invalid_argument (Faults among them) and std::runtime_error.
ReadRobot read_robot(const std::filesystem::path& file, urdf::Choices choices, bool strict, bool trusted);

/// Bodies, joints, all that was found, and names that changed.  Throws std::runtime_error where it cannot be written.
void write_robot_page(const std::filesystem::path& file, const ReadRobot& robot);

}  // namespace flexura::import
