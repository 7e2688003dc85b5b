// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/model/mesh.hpp"

/// What can be measured on a mesh: volume, mass centre, quality, outer surface, areas, pieces.
///
/// All integrals are taken over the (curved) cells as the shape functions describe them:
///     V = sum over cells of integral det J,   c = 1/V integral x,   J_c = integral (|x-c|^2 I -
///     (x-c)(x-c)^T)
namespace flexura::mesh {

/// Sizes of a body of density 1; shells count as their middle surface times their thickness.
struct Volumes {
  double volume = 0;                                   ///< [m^3]
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< [m], frame B
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();   ///< [m^5], about the centroid, axes of B
};
Volumes measure_volume(const Mesh& mesh);

/// Determinants of the Jacobian dx/d(r,s,t) of one cell at points of the reference cell.
Eigen::VectorXd jacobian_determinants(const Mesh& mesh, const CellBlock& block, Index cell,
                                      const Eigen::Matrix<double, Eigen::Dynamic, 3>& reference_points);

/// Shape quality of the solid cells.
///  - scaled Jacobian: at each corner the determinant of the unit vectors along the (straight) edges there,
///  times
///    sqrt(2) for tetrahedra and 2/sqrt(3) for wedges, so that 1 is a regular corner; a cell has its smallest
///    corner (pyramids: of the base);
///  - ratio: least over greatest det J at nodes, stiffness and volume quadrature points; 1 for straight
///  cells,
///    <= 0 for a cell that is turned inside out somewhere.
struct Quality {
  double min_scaled_jacobian = 1, mean_scaled_jacobian = 1;
  double min_ratio = 1, mean_ratio = 1;
  Index n_cells = 0;
  Index n_inverted = 0;   ///< cells with det J <= 0 at a stiffness or volume quadrature point
  Index n_below = 0;      ///< cells with ratio below kPoorRatio
  Index worst_cell = -1;  ///< counted through all solid blocks
};
inline constexpr double kPoorRatio = 0.05;
Quality measure_quality(const Mesh& mesh);

/// Straightens curved edges (mid-edge node to the middle of its corners) of all quadratic cells whose ratio
/// lies below `poor_ratio`, and repeats while neighbours become poor by it.  Returns the number of nodes
/// moved.
Index straighten_poor_cells(Mesh& mesh, double poor_ratio = kPoorRatio);

/// Sets mesh.boundary to the faces that belong to exactly one solid cell, oriented outwards (they inherit the
/// cells' orientation), one block for each face type, and then the blocks of shells.  boundary_face is cleared.  Throws
/// std::invalid_argument when a face belongs to three or more cells.
void extract_boundary(Mesh& mesh);

/// Area, area centroid and mean outward unit normal of surface cells.
struct Surface {
  double area = 0;
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal =
      Eigen::Vector3d::Zero();  ///< area mean; shorter than 1 where the surface is curved
};
Surface measure_surface(const Mesh& mesh, const std::vector<CellBlock>& faces);

/// Nodal weights of an area: `consistent` integrates the shape functions, integral N_k dA, so that sums over
/// nodes are exact integrals of interpolated fields (zero at tri6 corners, negative at quad8 corners);
/// `positive` shares each face's area by integral N_k^2 dA (Hinton, Rock and Zienkiewicz), always positive.
/// Order of `set.nodes`; sums to the area.  A set without faces gives equal weights that sum to 1.
enum class AreaWeights { consistent, positive };
Eigen::VectorXd area_weights(const Mesh& mesh, const NodeSet& set,
                             AreaWeights kind = AreaWeights::consistent);

/// Connected pieces: the piece of each node (-1 where no solid cell uses it); pieces are numbered by first
/// node.
struct Pieces {
  std::vector<Index> piece_of_node;
  Index count = 0;
};
Pieces find_pieces(const Mesh& mesh);

/// Removes nodes that no cell (solid, boundary or set face) and no set uses; returns how many went.
Index drop_unused_nodes(Mesh& mesh);

/// Least and greatest coordinates, row 0 and 1.
Eigen::Matrix<double, 2, 3> bounding_box(const Mesh& mesh);

}  // namespace flexura::mesh
