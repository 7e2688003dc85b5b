// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/urdf/convert.hpp"

namespace flexura::import::urdf {

/// Shapes of links as surfaces; counts the triangles of all of them.
class Drawer {
 public:
  Drawer(const std::filesystem::path& file, const Choices& choices) : file_(file), choices_(choices) {}

  /// Boxes that are turned in the link, meshes: triangles, which a rigid superelement carries.  Without those,
  /// the mechanism file's own solids.  What cannot be drawn is noted.
  void draw(const Link& link, Body& body, Findings& findings);

  /// What the shapes enclose, filled with density 1, in the link's frame; without mass where none of them encloses anything.  Meshes
  /// count where they are closed surfaces.
  MassProperties filled(const std::vector<Shape>& shapes);

 private:
  Surface mesh_of(const Shape& shape);

  std::filesystem::path file_;
  const Choices& choices_;
  std::size_t n_triangles_ = 0;
};

}  // namespace flexura::import::urdf
