// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/mesh.hpp"

/// Isoparametric solid elements.  An element is a cell shape (its functions N_a(xi) are those of
/// mesh/model/cells/cell.hpp) and two quadrature rules; the matrices (solid.hpp) are shared:
///
///     x = sum_a N_a(xi) x_a,   u = sum_a N_a(xi) u_a,   J = dx/dxi,   dN_a/dx = J^-T dN_a/dxi
///
/// Each solid cell type has one (mesh/model/cells/record.hpp says what a new one takes); another formulation of a type is an
/// entry in element.cpp and, if it has displacements of its own, an Enhancement.
/// O. C. Zienkiewicz, R. L. Taylor, The Finite Element Method, vol. 1, chapters 5 and 6.
namespace flexura::reduce {

/// The largest number of nodes of an element (hex27).
inline constexpr int kMaxNodes = 27;

/// Shape functions at the points of a quadrature rule, computed once.
struct TabulatedRule {
  struct Point {
    double weight;
    Eigen::Vector3d xi;
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxNodes, 1> N;
    Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxNodes, 3> dN;  ///< row a = dN_a/dxi
  };
  std::vector<Point> points;
};

/// How a consistent mass matrix is made diagonal.
enum class Lumping {
  row_sum,  ///< elements whose row sums are positive: those with corner nodes only
  scaled,   ///< the diagonal, scaled to the element's mass (Hinton, Rock, Zienkiewicz 1976): quadratic
            ///< elements
};

/// Displacement modes that vanish at the nodes and are condensed within the element (solid.hpp).
enum class Enhancement {
  none,
  bubbles,  ///< 1 - xi^2, 1 - eta^2, 1 - zeta^2 (Wilson), made to pass the patch test (Taylor, Beresford,
            ///< Wilson 1976)
};

/// Of which strains the stiffness is made.
enum class Strains {
  whole,
  mean_volume,  ///< the volume's change is its mean over the element (B-bar; T. J. R. Hughes 1980)
  uniform,  ///< all of it is the mean; what has none, hourglasses, has a small stiffness (Flanagan, Belytschko 1981)
  at_points,  ///< those at the points of the stiffness's rule, and between them what these give (reduced integration)
};

struct Element {
  mesh::CellType type;
  int n_nodes;
  TabulatedRule stiffness;
  TabulatedRule mass;
  TabulatedRule centre;  ///< one point
  Lumping lumping;
  Enhancement enhancement;
  Strains strains = Strains::whole;
};

/// Which of several elements of a cell type to take.
enum class Formulation {
  standard,  ///< displacements only
  enhanced,  ///< hex8 with bubbles: does not lock in bending; the same as standard for all others
  reduced,  ///< hex20 with 2 x 2 x 2 points for the stiffness, hex8 with uniform strains; the same as standard for all others
  mean_volume,  ///< hex8 with the mean change of its volume; the same as standard for all others
};

/// The formulation of a block whose deck says how it is integrated, else the part's.
Formulation formulation_of(const mesh::CellBlock& block, Formulation of_part);

/// Tabulates a cell type's shape functions at a rule's points.
TabulatedRule tabulate(mesh::CellType type, const mesh::Quadrature& rule);

/// The solid element of a cell type; std::invalid_argument for types that are not solids.
const Element& solid_element(mesh::CellType type, Formulation formulation = Formulation::standard);

}  // namespace flexura::reduce
