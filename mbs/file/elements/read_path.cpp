// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/read_path.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace flexura::mbs {

input::Key path_key() {
  return input::texts(
      "path",
      "markers of one body in the order in which they are passed, \"body.marker\": interfaces of a "
      "superelement, linked markers of its surface, points of a beam; a smooth line runs through them, "
      "through wherever they are carried");
}

std::shared_ptr<const BodyPath> read_path(const input::Section& section, const ReadContext& context) {
  std::vector<int> markers;
  std::vector<Pose> undeformed;
  int body = -1;
  std::string first;
  for (const std::string& name : section.texts("path")) {
    const int marker = context.marker_of(section, "path", name);
    const auto [on, X] = context.undeformed(marker);
    if (markers.empty()) {
      body = on;
      first = name;
    }
    if (on != body)
      section.refuse("path", fmt::format("\"{}\" is on another body than \"{}\"", name, first),
                     "let all markers of a path be on one body");
    markers.push_back(marker);
    undeformed.push_back(X);
  }
  if (markers.size() < 2)
    section.refuse("path", fmt::format("has {} marker{}", markers.size(), markers.size() == 1 ? "" : "s"),
                   "name two at least");
  try {
    return std::make_shared<const BodyPath>(std::move(markers), undeformed);
  } catch (const std::invalid_argument& error) {
    section.refuse("path", error.what(), "name places along a line, each once");
  }
}

}  // namespace flexura::mbs
