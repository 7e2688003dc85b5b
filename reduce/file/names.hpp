// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"

namespace flexura::reduce {

/// Names of one kind and their numbers.
struct Names {
  const char* kind;
  std::vector<std::string> known;

  int find(const input::Section& in, const std::string& key, const std::string& word) const {
    const auto it = std::find(known.begin(), known.end(), word);
    if (it == known.end())
      in.refuse(key, fmt::format("\"{}\" is not a {}{}", word, kind, input::suggestion(word, known)));
    return static_cast<int>(it - known.begin());
  }
  /// The only one where the key is left out.
  int find_or_only(const input::Section& in, const std::string& key) const {
    if (in.has(key)) return find(in, key, in.text(key));
    if (known.size() != 1)
      throw input::InputError(
          fmt::format("{}: name a {} with `{}`; there are {}", in.where(), kind, key, known.size()));
    return 0;
  }
};

}  // namespace flexura::reduce
