// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/elements/solid.hpp"

/// What estimates ask of a mesh, cell by cell.
namespace flexura::reduce {

inline bool is_quadratic(mesh::CellType type) {
  return mesh::nodes_per_cell(type) > mesh::shape_of(type).corners;
}

inline NodePositions positions(const mesh::Mesh& mesh, const mesh::CellBlock& block, Eigen::Index cell) {
  NodePositions x(block.nodes.cols(), 3);
  for (Eigen::Index a = 0; a < x.rows(); ++a) x.row(a) = mesh.points.row(block.nodes(cell, a));
  return x;
}

/// The place of its material in the part's list.
inline std::size_t material_of(const mesh::CellBlock& block, Eigen::Index cell) {
  return block.material.empty() ? 0
                                : static_cast<std::size_t>(block.material[static_cast<std::size_t>(cell)]);
}

}  // namespace flexura::reduce
