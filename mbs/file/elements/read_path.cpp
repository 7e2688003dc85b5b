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
  // Markers out of order: a smooth line through them loops back, which no rail does between two neighbours.
  const std::vector<std::string> names = section.texts("path");
  for (std::size_t i = 2; i < names.size(); ++i) {
    const Vector3d before = undeformed[i - 1].p - undeformed[i - 2].p,
                   behind = undeformed[i].p - undeformed[i - 1].p;
    constexpr double kBack = -0.7;  // cosine: 135 deg
    if (before.dot(behind) < kBack * before.norm() * behind.norm())
      section.refuse(
          "path", fmt::format("turns back at \"{}\"", names[i - 1]),
          "name the markers in the order in which they are passed; round a sharp bend name some between");
  }
  try {
    return std::make_shared<const BodyPath>(std::move(markers), undeformed);
  } catch (const std::invalid_argument& error) {
    section.refuse("path", error.what(), "name places along a line, each once");
  }
}

}  // namespace flexura::mbs
