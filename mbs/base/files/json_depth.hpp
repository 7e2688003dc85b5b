// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

namespace flexura::files {

/// The text itself, or "", which is no JSON, where its lists and objects nest deeper than 60: the library reads
/// any depth, but copies and prints one level within the other and ends on the stack.
std::string_view shallow_json(std::string_view text);

}  // namespace flexura::files
