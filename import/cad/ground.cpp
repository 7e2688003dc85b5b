// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/ground.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace flexura::import::cad {

int find_ground(const Assembly& assembly, const std::vector<PlacedPart>& parts,
                const std::vector<std::string>& names, const std::string& wanted) {
  const std::size_t n = parts.size();
  if (wanted.empty()) {
    int ground = 0;
    double largest = -1.0;
    for (std::size_t i = 0; i < n; ++i)
      if (const double box = (parts[i].high - parts[i].low).prod(); box > largest) {
        largest = box;
        ground = static_cast<int>(i);
      }
    return ground;
  }
  std::vector<int> found;
  for (std::size_t i = 0; i < n; ++i)
    if (names[i] == wanted || assembly.instances[i].name == wanted) found.push_back(static_cast<int>(i));
  if (found.size() != 1) {
    std::string list;
    for (std::size_t i = 0; i < std::min<std::size_t>(n, 12); ++i) list += (i > 0 ? ", " : "") + names[i];
    throw std::invalid_argument(
        fmt::format("--ground {}: {} bodies of the assembly are called so; it has {}{}", shown(wanted),
                    found.size(), list, n > 12 ? ", ..." : ""));
  }
  return found.front();
}

}  // namespace flexura::import::cad
