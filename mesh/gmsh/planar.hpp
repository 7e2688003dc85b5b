// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "mesh/gmsh/cad.hpp"

/// Plane regions as meshes of six-node triangles, for beam sections.
namespace flexura::mesh {

using PlaneLoop = std::vector<std::array<double, 2>>;  ///< corners [m], not closed

/// A polygon with holes, which may reach over its edge and over each other.  Regions may overlap: what two share belongs to the
/// first.  No polygon may cross or touch itself (the geometry kernel would abort).
struct PlaneRegion {
  PlaneLoop outer;
  std::vector<PlaneLoop> holes;
};

struct PlanarOptions {
  std::vector<PlaneRegion> regions;  ///< or
  std::filesystem::path cad;         ///< a STEP, IGES or BREP file of faces in one coordinate plane
  double size = 0;  ///< greatest edge length [m], at most area over outline; 0 = half of that
  double time_limit_s = 120;
  std::filesystem::path worker;  ///< the child program; empty = flexura-mesh beside this program or in PATH
};

struct PlanarMesh {
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> points;  ///< n x 2 [m]
  /// m x 6: corners counter-clockwise, mid-side nodes of 01, 12, 20.
  Eigen::Matrix<int, Eigen::Dynamic, 6, Eigen::RowMajor> triangles;
  std::vector<int> region;            ///< m; number of the region, or of the face in the file
  std::vector<std::string> messages;  ///< what the user should know
};

/// Neighbouring regions share their nodes.  Faces of a file in the plane x-y give (x, y), in y-z (y, z), in
/// z-x (z, x). Throws std::invalid_argument for what cannot be meshed.
PlanarMesh mesh_planar(const PlanarOptions& options, const Progress& progress = {});

}  // namespace flexura::mesh
