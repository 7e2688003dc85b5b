// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/elements/element.hpp"

/// Matrices of solid elements, small displacements, linear elasticity.
///
///     K_e = integral B^T D B dV,   B_a = [ N_a,x  0      0     ]      strains (xx, yy, zz, xy, yz, zx)
///                                        [ 0      N_a,y  0     ]
///                                        [ 0      0      N_a,z ]
///                                        [ N_a,y  N_a,x  0     ]
///                                        [ 0      N_a,z  N_a,y ]
///                                        [ N_a,z  0      N_a,x ]
///     m_e = integral rho N N^T dV (n x n); the mass matrix of the 3 n dofs is m_e (x) I_3
///
/// Enhancement::bubbles adds displacements sum_k M_k(xi) alpha_k, M_k = 1 - xi_k^2, that belong to the
/// element alone and are condensed: K_e - K_ua K_aa^-1 K_au.  A brick in bending then curves instead of
/// shearing.  Their gradients are taken with the Jacobian of the centre, (det J_0 / det J) J_0^-T dM_k/dxi,
/// so that their mean strain is zero and the patch test holds in any shape (R. L. Taylor, P. J. Beresford, E.
/// L. Wilson, Int. J. Numer. Meth. Eng. 10 (1976), 1211).
///
/// Dofs are ordered u_x, u_y, u_z of node 0, then of node 1, ...
namespace flexura::reduce {

using NodePositions = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxNodes, 3>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

enum class MassKind {
  consistent,
  lumped,   ///< diagonal
  reduced,  ///< consistent, but integrated at the stiffness's points (tet10: 4), as CalculiX does
};

/// Computes K_e (3n x 3n) from node positions [m] and elasticity [Pa].  Returns the smallest det J at the
/// quadrature points; where it is not positive the element is inverted and K_e is meaningless.
double element_stiffness(const Element& element, const NodePositions& x, const Matrix6& D,
                         Eigen::MatrixXd& K_e);

/// The part of K_e that holds hourglasses, of elements with uniform strains; zero of others.
void fill_hourglass_stiffness(const Element& element, const NodePositions& x, const Matrix6& D,
                              Eigen::MatrixXd& K);

/// Computes m_e (n x n) from node positions [m] and density [kg/m^3]; lumped is diagonal, by the element's
/// own rule. Returns the smallest det J at the quadrature points.
double element_mass(const Element& element, const NodePositions& x, double density, MassKind kind,
                    Eigen::MatrixXd& m_e);

/// dN_a/dx (n x 3) at a point; returns det J.
double spatial_gradients(const TabulatedRule::Point& point, const NodePositions& x, NodePositions& gradients);

/// B_a: strain (6) of a unit displacement of a node, from the node's shape gradient.
Eigen::Matrix<double, 6, 3> strain_operator(const Eigen::RowVector3d& gradient);

}  // namespace flexura::reduce
