// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "mesh/gmsh/cad.hpp"

namespace flexura::mesh {

inline std::string project(const std::string& path) {
  return FLEXURA_SOURCE_DIR "/" + path;
}
inline std::string part_file(const std::string& name) {
  return project("cases/cad_parts/" + name);
}

inline CadOptions options_for(const std::string& path) {
  CadOptions options;
  options.path = path;
  options.worker = FLEXURA_BIN_DIR "/flexura-mesh";
  return options;
}

/// Outward planes and bores of the list against the mesh: the mean normal of a face's cells (they are
/// oriented by the solid cells they bound) looks along the listed normal, or towards a bore's axis.
inline int count_faces_that_look_inwards(const CadMesh& part) {
  int wrong = 0;
  for (const Face& face : part.cad.faces) {
    if (face.kind != FaceKind::plane && face.kind != FaceKind::cylinder) continue;
    std::size_t k = 0;
    double along = 0;
    for (const CellBlock& block : part.mesh.boundary)
      for (Index cell = 0; cell < block.nodes.rows(); ++cell, ++k) {
        if (part.mesh.boundary_face[k] != face.number) continue;
        const Eigen::Vector3d a = part.mesh.points.row(block.nodes(cell, 0)).transpose(),
                              b = part.mesh.points.row(block.nodes(cell, 1)).transpose(),
                              c = part.mesh.points.row(block.nodes(cell, 2)).transpose();
        const Eigen::Vector3d n = (b - a).cross(c - a);
        Eigen::Vector3d radial = (a + b + c) / 3 - face.axis_point;
        radial -= face.axis * face.axis.dot(radial);
        along += face.kind == FaceKind::plane ? n.dot(face.normal) : n.dot(radial) * (face.hole ? -1 : 1);
      }
    wrong += along < 0;
  }
  return wrong;
}

}  // namespace flexura::mesh
