// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

/// What the program and its meshing child say to each other.
///
/// Descriptors of the child: 0 the job (JSON), 1 and 2 a log, 3 the result, 4 progress lines
/// "fraction<tab>stage\n". The result is a JSON text of 8-byte length in front, then the arrays in the order
/// of Arrays, each with the length that the text states.  Both sides run on one machine and come from one
/// build, so numbers are native.
namespace flexura::mesh {

inline constexpr int kResultDescriptor = 3, kProgressDescriptor = 4;
/// The child opens the file here and gives this name of it to gmsh, which chooses a reader by the ending, uncompresses by a shell,
/// and runs NAME.opt beside it: a name without ending and neighbours leaves the choice to us.
inline constexpr int kFileDescriptor = 5;
inline constexpr const char* kFileOfDescriptor = "/proc/self/fd/5";

struct Job {
  std::string
      task;  ///< "list", "picture" or "mesh" a CAD file, "sheet": its faces (worker_sheet.hpp), "read" a mesh or "read shells", "planar", "curves": see planar.hpp, curves.hpp
  std::string path, format;
  double to_m = 1e-3;  ///< model units (mm) to m
  std::vector<int> solids;
  bool fuse = false, heal = false;
  int order = 2;
  double size = 0, size_min = 0;  ///< [m]
  std::vector<double> sizes;      ///< x, y, z, greatest edge length there [m]; empty: `size` everywhere
  double elements_per_circle = 0;
  int most_triangles = 0;     ///< with more on the surface, sizes grow until it fits; 0 = no limit
  int most_tetrahedra = 0;    ///< likewise of the volume
  int surface_algorithm = 6;  ///< gmsh's Mesh.Algorithm: 6 frontal-Delaunay, 5 Delaunay, 1 MeshAdapt
  double turn = 0;            ///< "curves": greatest angle between pieces [rad]
  std::string note;  ///< what the stages are said to be besides: the recipe, and why the one before failed
  int parent = 0;    ///< process id; the child ends when it is gone
  /// "planar": for each region its outer loop and its holes, y and z of each corner [m].
  std::vector<std::vector<std::vector<double>>> regions;
};

struct SolidRecord {
  int number = 0, same_as = 0;
  std::string name;
  double volume = 0;
  std::array<double, 3> centroid{};
  std::array<double, 9> inertia{};
  std::array<double, 6> box{};
};

/// Cells of one type, or a group of nodes, in a mesh that was read.
struct BlockRecord {
  int type = 0;  ///< CellType
  std::uint64_t n = 0;
};
struct GroupRecord {
  std::string name;
  std::uint64_t n = 0;
};

struct FaceRecord {
  int number = 0, solid = 0, kind = 4;
  int entity = 0;  ///< of the child alone: gmsh's number, where it is another
  std::string name;
  double area = 0, radius = 0, length = 0, sweep = 0;
  bool hole = false;
  std::array<double, 3> centroid{}, normal{}, axis_point{}, axis{};
  std::array<double, 6> box{};
};

/// All lengths in m.
struct ResultRecord {
  std::string error;  ///< not empty: nothing else counts
  std::vector<SolidRecord> solids;
  std::vector<int> kept;        ///< numbers of the solids that the faces and the mesh belong to
  double volume = 0, area = 0;  ///< of what is kept, after fusing and healing
  double outline = 0;           ///< "sheet": length of the free edges
  std::array<double, 3> centroid{};
  std::vector<FaceRecord> faces;
  std::vector<std::string> messages;
  double size = 0, size_min = 0, elements_per_circle = 0;  ///< as used
  bool graded =
      false;  ///< sizes grow away from the edges, in place of spreading those of short edges over whole faces
  std::uint64_t n_points = 0, n_tetrahedra = 0, n_triangles = 0, n_integers = 0;
  std::vector<BlockRecord> blocks;
  std::vector<GroupRecord> groups;
};

struct Arrays {
  std::vector<double> points;            ///< 3 n_points
  std::vector<std::int32_t> tetrahedra;  ///< (4 or 10) n_tetrahedra, node order of Mesh
  std::vector<std::int32_t> triangles;   ///< 3 n_triangles, corners only
  std::vector<std::int32_t> face;        ///< n_triangles, face numbers
  /// Of a mesh that was read: the nodes' labels; for each block its cells' labels and then their nodes (from
  /// 0, order of Mesh); for each group its nodes.
  std::vector<std::int64_t> integers;
};

}  // namespace flexura::mesh
