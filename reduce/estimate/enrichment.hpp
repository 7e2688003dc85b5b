// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "mesh/model/cells/cell.hpp"

/// The functions that the next higher degree adds to a cell.
///
/// They vanish at the cell's nodes and belong to its edges and faces, so that cells that share one share the function
/// (O. C. Zienkiewicz, J. P. de S. R. Gago, D. W. Kelly, Computers & Structures 16 (1983), 53; B. Szabo, I. Babuska,
/// Finite Element Analysis, chapter 6).  With t from -1 to 1 along an edge, linear cells gain
///
///     edges   1 - t^2
///
/// and cells of second degree
///
///     edges        t (1 - t^2)                t from the node of the lower number to the other
///     triangles    27 l_1 l_2 l_3
///     rectangles   (1 - s^2) (1 - t^2)
///
/// each times what brings it linearly to zero on the rest of the cell.
namespace flexura::reduce {

/// One function: of the edge or face with these corners (local numbers; -1 fills up).
struct EnrichmentFunction {
  std::array<int, 4> corners;
  bool odd;  ///< changes its sign with the edge's direction
};

/// Empty where the enrichment of a cell type is not known (pyramids, hex27).
const std::vector<EnrichmentFunction>& enrichment_of(mesh::CellType type);

/// Values (n) and derivatives by the reference coordinates (n x 3) of a cell's or a face's functions at a point, edges
/// from their first to their second corner.  Faces: the traces of the cells' functions, derivatives not set.
struct EnrichmentValues {
  Eigen::VectorXd w;
  Eigen::Matrix<double, Eigen::Dynamic, 3> dw;
};
EnrichmentValues evaluate_enrichment(mesh::CellType type, const Eigen::Vector3d& point);

}  // namespace flexura::reduce
