// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace flexura::import {

/// The program xacro is on this machine.
bool has_xacro();

/// The URDF that the program xacro of this machine makes of a template.  xacro evaluates Python: `trusted` says that it may; else
/// templates whose substitutions, in all files that they include, are arithmetic are expanded, and others refused.  Throws
/// std::invalid_argument where it is refused or xacro is not there, std::runtime_error where xacro fails.
std::string expand_xacro(const std::filesystem::path& file, const std::vector<std::string>& packages,
                         bool trusted);

}  // namespace flexura::import
