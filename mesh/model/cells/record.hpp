// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/cells/dual.hpp"

/// All that there is to know of a cell type.  A new type is a record in its family's file and an enumerator at the end of
/// cell_type.hpp; a new family is a file of its own in this folder, declared below and listed in records.cpp.  Shape
/// functions, quadrature, matrices, readers and writers of all formats follow from the record.
namespace flexura::mesh {

/// A cell type in the formats of others; -1 or empty where they have none.
struct ForeignCell {
  int gmsh = -1;
  std::vector<int> gmsh_order = {};     ///< place in gmsh's order of each of our nodes; empty: the same
  int vtk = -1;                         ///< our order is VTK's
  std::string abaqus = {};              ///< "C3D10"
  std::vector<int> abaqus_order = {};   ///< our node at each place of Abaqus' order; empty: the same
  std::string nastran = {};             ///< "CTETRA", of both orders
  std::vector<int> nastran_order = {};  ///< place on the card of each of our nodes; empty: the same
  int unv = -1;                         ///< descriptor of data set 2412
  std::vector<int> unv_order = {};      ///< place in the record of each of our nodes; empty: the same
};

struct CellRecord {
  using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;
  /// N at x, numbers that carry derivatives; `nodes` and `edges` of the record.
  using ShapeFunctions = std::vector<Dual> (*)(const CellRecord& record, const std::array<Dual, 3>& x);

  CellType type;
  const char* name;
  int dimension;
  CellShape shape;
  Points nodes;  ///< reference coordinates
  ShapeFunctions functions;
  Quadrature volume, stiffness;  ///< cell.hpp
  /// The type whose stiffness points have this one's best stresses; none: the centre.
  std::optional<CellType> stress_points = {};
  ForeignCell foreign = {};

  bool is_solid() const { return dimension == 3; }
  /// Corner nodes only.
  bool is_linear() const { return nodes.rows() == shape.corners; }
};

/// Corners, then the middles of edges, then zeros (centres).
CellRecord::Points with_middles(const CellRecord::Points& corners,
                                const std::vector<std::array<int, 2>>& edges, int n_nodes);

/// Faces of corner rings, counter-clockwise from outside, with the mid-edge nodes of a quadratic cell.
std::vector<CellFace> faces_of(const std::vector<std::vector<int>>& rings,
                               const std::vector<std::array<int, 2>>& edges, int corners, bool quadratic);

/// Lagrange on -1, 0, 1, for the node at a.
inline Dual quadratic_line(double a, const Dual& r) {
  return a == 0 ? (1.0 - r) * (1.0 + r) : 0.5 * r * (r + a);
}

/// Of triangles and tetrahedra, of both orders, in barycentric coordinates.
std::vector<Dual> simplex_functions(const CellRecord& record, const std::array<Dual, 3>& x);

/// Of quad8 and hex20: products, on corners times what vanishes at the middles of edges.
std::vector<Dual> serendipity_functions(const CellRecord& record, const std::array<Dual, 3>& x);
/// Of squares and cubes: products of lines' functions of the order that the record has.
std::vector<Dual> product_functions(const CellRecord& record, const std::array<Dual, 3>& x);

// Each family's types, one file each.
std::vector<CellRecord> lines();
std::vector<CellRecord> triangles();
std::vector<CellRecord> quadrilaterals();
std::vector<CellRecord> tetrahedra();
std::vector<CellRecord> bricks();
std::vector<CellRecord> wedges();
std::vector<CellRecord> pyramids();

/// All of them.
const std::vector<CellRecord>& cell_records();
/// Of a type; std::invalid_argument for a number that is none.
const CellRecord& record_of(CellType type);

}  // namespace flexura::mesh
