// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "mesh/model/cells/cell_type.hpp"

/// A finite-element mesh as every reader and mesher delivers it and every assembler takes it.
/// Lengths in m, indices from 0, coordinates in the part's own (CAD) frame B.
namespace flexura::mesh {

using Index = std::int32_t;

/// How a foreign program integrates a solid of this shape, where the deck says so.
enum class CellVariant : std::uint8_t {
  standard,     ///< as the part asks for
  reduced,      ///< stiffness with the next lower Gauss rule (C3D20R, C3D8R)
  bubbles,      ///< incompatible modes (C3D8I)
  mean_volume,  ///< the mean change of volume (C3D8)
};

/// Cells of one type and variant, one row of node indices each.
struct CellBlock {
  CellType type = CellType::tet10;
  CellVariant variant = CellVariant::standard;
  Eigen::Matrix<Index, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>
      nodes{};                        ///< n_cells x nodes_per_cell
  std::vector<Index> material{};      ///< n_cells; index into the part's materials, empty = all 0
  std::vector<std::int64_t> label{};  ///< n_cells; the cell numbers of the file it came from, empty = none
  std::vector<double> thickness{};    ///< shells: n_cells [m]
  std::vector<double>
      offset{};  ///< shells: n_cells, from the nodes to the middle surface along the normal [m]
};

/// A named set of nodes, with the surface cells that span it where it came from a face (for area weights).
struct NodeSet {
  std::vector<Index> nodes;  ///< ascending, unique
  std::vector<CellBlock> faces;
};

struct Mesh {
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> points;  ///< n_nodes x 3 [m], frame B
  std::vector<CellBlock> solids;
  std::vector<CellBlock> shells;    ///< tri3 and quad4, whose nodes have six dofs
  std::vector<CellBlock> boundary;  ///< the outer surface, oriented outwards
  std::vector<Index>
      boundary_face;  ///< CAD or mesh face number of each boundary cell, in block order; may be empty
  std::map<std::string, NodeSet> sets;
  std::vector<std::int64_t> node_label;  ///< the node numbers of the file it came from, empty = none

  Index n_nodes() const { return static_cast<Index>(points.rows()); }
  Index n_solid_cells() const;
};

}  // namespace flexura::mesh
