// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/json_depth.hpp"

namespace flexura::files {

std::string_view shallow_json(std::string_view text) {
  constexpr int kDeepest = 60;  // as of TOML files
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text && c == '\\')
      ++i;
    else if (c == '"')
      in_text = !in_text;
    else if (!in_text && (c == '[' || c == '{') && ++depth > kDeepest)
      return {};
    else if (!in_text && (c == ']' || c == '}'))
      --depth;
  }
  return text;
}

}  // namespace flexura::files
