// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/page/numbered_face.hpp"

namespace flexura::mesh {

view::NumberedFace numbered_face(const Face& face) {
  const bool has_axis = face.kind == FaceKind::cylinder || face.kind == FaceKind::cone;
  // "face 12: bore, ...": the number stands beside it.
  const std::string text = describe(face);
  const auto colon = text.find(": ");
  return {.number = static_cast<int>(face.number),
          .text = colon == std::string::npos ? text : text.substr(colon + 2),
          .kind = name_of(face.kind),
          .point = has_axis || face.kind == FaceKind::sphere ? face.axis_point : face.centroid,
          .axis = has_axis ? face.axis : face.normal,
          .lines = selection_lines(face)};
}

}  // namespace flexura::mesh
