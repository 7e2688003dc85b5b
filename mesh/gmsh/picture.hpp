// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>

#include "mesh/gmsh/cad.hpp"

namespace flexura::mesh {

/// Triangles of the faces that list_faces lists, for a picture: coarse, and not to be computed with. Lengths in m.
struct FacesPicture {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  std::vector<Index> face;                 ///< of each triangle: Face::number
  std::vector<std::pair<int, int>> edges;  ///< of the part, pairs of vertices
};

/// Throws like list_faces, and std::runtime_error where gmsh draws none of them.
FacesPicture draw_faces(const CadOptions& options, const Progress& progress = {});

}  // namespace flexura::mesh
