// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "mesh/model/cells/cell_type.hpp"

/// What a cell shape is: corners, edges, faces, reference coordinates, shape functions, quadrature.
///
/// Reference cells: simplices 0 <= r, s, t with r + s + t <= 1; quadrilaterals and hexahedra [-1, 1]^d;
/// wedges the triangle times t in [-1, 1]; pyramids the base [-1, 1]^2 at t = 0 and the apex (0, 0, 1). Node
/// order: corners, one node for each edge in the order of `edges`, then for quad9 the centre and for hex27
/// the face centres (-x, +x, -y, +y, -z, +z) and the centre, as in the VTK file format.
namespace flexura::mesh {

struct CellFace {
  CellType type;
  std::vector<int> nodes;  ///< local nodes in the order of `type`, seen from outside counter-clockwise
};

struct CellShape {
  int corners;
  std::vector<std::array<int, 2>> edges;  ///< corner pairs; a quadratic cell has node corners + e on edge e
  std::vector<CellFace> faces;            ///< of solids; empty for surfaces and lines
};

const CellShape& shape_of(CellType type);

/// A quadrature rule on the reference cell; weights sum to the reference volume.
struct Quadrature {
  Eigen::Matrix<double, Eigen::Dynamic, 3> points;
  Eigen::VectorXd weights;
};

/// Exact for the volume and the first moments of curved cells of each type (det J of a tet10 times a
/// coordinate is of degree 5; the tensor products of 4-point Gauss rules integrate degree 7 in each
/// direction).  All weights positive. Tetrahedra: Walkington's 14 points of degree 5; triangles: 7 points of
/// degree 5 (Radon).
const Quadrature& volume_quadrature(CellType type);

/// The points at which stiffness is integrated: tet4 1, tet10 4, hex8 2x2x2, hex20 and hex27 3x3x3, wedge6
/// 3x2, wedge15 7x3 (triangle x line), pyramids 2x2x2 and 3x3x3 (conical).
const Quadrature& stiffness_quadrature(CellType type);

/// Reference coordinates of the nodes, nodes_per_cell x 3.
const Eigen::Matrix<double, Eigen::Dynamic, 3>& reference_nodes(CellType type);

/// Shape functions N and their derivatives dN (nodes x 3; columns beyond the dimension are zero) at a
/// reference point.  Lagrange, serendipity (quad8, hex20, wedge15); pyramids after Bedrosian, Int. J. Numer.
/// Methods Eng. 35 (1992) 95: rational, not to be evaluated at the apex itself (its limit is taken a distance
/// 1e-9 below).
struct ShapeValues {
  Eigen::VectorXd N;
  Eigen::Matrix<double, Eigen::Dynamic, 3> dN;
};
ShapeValues evaluate_shape(CellType type, const Eigen::Vector3d& point);

}  // namespace flexura::mesh
