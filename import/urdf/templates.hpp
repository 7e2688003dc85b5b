// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

/// Templates of xacro, as far as this program looks into them: xacro expands them, and what it evaluates is Python.
namespace flexura::import::urdf {

struct Place {
  int line = 0;
  std::string text;
};

struct Template {
  std::optional<Place> first;  ///< the first element that only xacro understands; none: a robot as it stands
  /// Substitutions that are more than arithmetic on names and numbers: "${...}" with calls (but of mathematical functions), attributes or
  /// brackets, "$(...)" but find, arg and dirname.
  std::vector<Place> code;
  std::vector<Place> includes;  ///< names of included files as they are written
};

/// Throws std::invalid_argument where the text is no XML with <robot>.
Template look_through(const std::string& text, const std::filesystem::path& file);

/// "${" ... "}" holds numbers, names, operators, quoted words and mathematical functions alone.
bool is_arithmetic(const std::string& expression);

}  // namespace flexura::import::urdf
