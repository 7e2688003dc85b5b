// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "mesh/model/face.hpp"
#include "mesh/model/geometry.hpp"
#include "mesh/model/mesh.hpp"

/// CAD files (STEP, IGES, BREP) as lists of faces and as meshes of tetrahedra.
///
/// gmsh and its OpenCASCADE kernel run in a child process, `flexura-mesh`: some parts crash or hang them, and
/// then the child is given up and the part is tried another way or refused with one sentence.  The child
/// reads its job and writes its result through inherited descriptors, so nothing is left behind whatever
/// happens, and it dies with its parent.
namespace flexura::mesh {

using Progress = std::function<void(std::string_view stage, double fraction)>;

struct CadOptions {
  std::filesystem::path path;
  std::string
      unit;  ///< m, mm, cm, um, inch, ft: overrides what the file says; empty = as declared (BREP: mm)
  std::vector<int> solids;      ///< numbers as listed; empty = the only one
  bool fuse = false;            ///< unite the chosen solids (none chosen: all) to one
  int order = 2;                ///< 1: tet4, 2: tet10
  double size = 0;              ///< greatest edge length [m]; 0 = from the part, see automatic_size
  int most_triangles = 25000;   ///< of an automatic mesh, about 70,000 nodes of a thin-walled tet10 part
  int most_tetrahedra = 60000;  ///< likewise of a bulky one, about 90,000 nodes
  std::vector<double>
      sizes;  ///< x, y, z and greatest edge length there [m], in frame B; empty = `size` everywhere
  double elements_per_circle =
      8;                      ///< around curved faces where size_min allows; 0 = no refinement at curvature
  double size_min = 0;        ///< least edge length [m]; 0 = size / 3
  bool heal = false;          ///< OpenCASCADE's shape healing first; changes volumes slightly
  double time_limit_s = 600;  ///< for all tries together
  std::filesystem::path worker;  ///< the child program; empty = flexura-mesh beside this program or in PATH
};

struct CadSolid {
  int number = 0;  ///< from 1, in the order of the file
  std::string name;
  double volume = 0;  ///< [m^3]
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< about the centroid for density 1 [m^5]
  Eigen::Matrix<double, 2, 3> box = Eigen::Matrix<double, 2, 3>::Zero();
  int same_as = 0;  ///< the solid of which this one is a copy in the same place; 0 = none
};

struct CadReport {
  std::string unit;              ///< of the file's numbers, "mm"
  std::vector<CadSolid> solids;  ///< all of the file
  std::vector<Face> faces;  ///< of the chosen solids (after fusing); none chosen: of all that are no copies
  double area = 0;          ///< of these faces [m^2]
  std::vector<std::string> messages;
};

/// What can be chosen in a CAD file, without meshing it.  Throws std::invalid_argument for files that are
/// missing, empty or not CAD files, std::runtime_error where OpenCASCADE fails.
CadReport list_faces(const CadOptions& options, const Progress& progress = {});

struct MeshReport {
  Index n_nodes = 0, n_cells = 0;
  double size = 0;  ///< greatest edge length asked for [m]
  Quality quality;
  Index n_straightened = 0;           ///< mid-edge nodes put on straight edges to mend turned cells
  double cad_volume = 0, volume = 0;  ///< [m^3]
  Eigen::Vector3d cad_centroid = Eigen::Vector3d::Zero(), centroid = Eigen::Vector3d::Zero();
  double volume_error = 0;  ///< volume / cad_volume - 1
  double seconds = 0;
  std::vector<std::string> messages;  ///< what was tried, mended, taken away; warnings
};

struct CadMesh {
  Mesh mesh;  ///< boundary_face holds face numbers of `cad.faces`; named faces are sets
  CadReport cad;
  MeshReport report;
};

/// Meshes one solid (or the union of several).  Tries in this order, each with a message: as asked; another
/// surface algorithm; a greater least size; healing.  Volumes off by more than 0.5 % refine the curvature up
/// to twice, then stay as a warning.  Throws like list_faces, and std::runtime_error with the reason where
/// every try failed.
CadMesh mesh_cad(const CadOptions& options, const Progress& progress = {});

/// Refuses (std::invalid_argument) a size of which a part takes more elements than anything here can solve.
void require_few_cells(double size, double volume, double area);

/// Greatest edge length for a part: a wall's thickness 2 V / A, within 1/80 and 1/20 of the box's diagonal.
/// With it (size = 0) the mesh is also bounded: many small features raise the sizes, with a message.
double automatic_size(double volume, double area, double diagonal);

}  // namespace flexura::mesh
