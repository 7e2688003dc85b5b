// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string_view>

// How deep a TOML text nests, before it is parsed: the parser makes a table in a table of every dot of a key
// and takes them down by recursion, so that a key of 50,000 dots would end the program's stack.
namespace flexura::input {

// Brackets and dots of keys that may stand in one another.  Our files need a dozen.
inline constexpr int deepest_nesting = 60;

// The line (from 1) where the text nests deeper than that, if it does.
std::optional<int> line_nested_too_deep(std::string_view toml);

}  // namespace flexura::input
