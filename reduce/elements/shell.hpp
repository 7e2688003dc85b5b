// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/elements/material.hpp"
#include "reduce/elements/solid.hpp"

/// Flat shell elements with three or four nodes of six dofs (u, theta), thin to moderately thick.
///
/// Element axes: e_3 the normal (of a quadrilateral the cross product of its diagonals), e_1 along the line from
/// the middle of edge 4-1 to that of edge 2-3 (triangles: edge 1-2).  The corners of a warped quadrilateral are
/// carried to the flat one by rigid arms along e_3, so that rigid motions and equilibrium are exact.
///
/// Bending with transverse shear, beta = (theta_2, -theta_1), gamma = grad w + beta (I. Katili, Int. J. Numer.
/// Meth. Eng. 36 (1993), 1859 and 1885: DKMT, DKMQ):
///
///     beta = sum N_i beta_i + sum_k P_k s_k Db_k,   P_k quadratic, 1 at the middle of side k, s_k along it
///     Db_k = -3 / (2 L_k (1 + phi_k)) (w_j - w_i + L_k/2 s_k . (beta_i + beta_j)),  phi_k = 12 D_b / (L_k^2 D_s)
///     gamma . s_k = -2/3 phi_k Db_k, constant along each side, tangentially continuous inside
///
/// which is the discrete Kirchhoff element for phi = 0 and free of locking for all thicknesses.
///
/// Membrane with drilling rotation theta_3.  Triangles: the optimal template OPT (C. A. Felippa, Comput. Methods
/// Appl. Mech. Eng. 192 (2003), 2125).  Quadrilaterals: bilinear displacements with the incompatible modes of
/// solid.hpp (Taylor, Beresford, Wilson 1976) and the drilling energy of T. J. R. Hughes, F. Brezzi, Comput. Methods
/// Appl. Mech. Eng. 72 (1989), 105, with the modes in the rotation as well, so that bending in the plane is exact:
///
///     1/2 integral G t ((v,1 - u,2)/2 - theta_3)^2 dA
///
/// Unlike layers (shell_section.hpp) couple stretch and curvature: of the quadrilateral with its incompatible modes, of the
/// triangle by its mean strain.
///
/// Dofs are ordered u_x, u_y, u_z, theta_x, theta_y, theta_z of node 0, then of node 1, ... in the axes of the mesh.
namespace flexura::reduce {

/// Axes (columns e_1, e_2, e_3), place and size of an element.
struct ShellFrame {
  Eigen::Matrix3d R;
  Eigen::Vector3d centre;
  Eigen::Matrix<double, Eigen::Dynamic, 2, 0, 4, 2> x;  ///< corners in the axes, from the centre [m]
  Eigen::VectorXd warp;                                 ///< of each corner along e_3 [m]
  double area = 0.0;                                    ///< [m^2]
  double smallest_det = 0.0;  ///< of the Jacobian at the quadrature points; not positive: folded or flat
};
ShellFrame shell_frame(const NodePositions& x);

/// K_e (6n x 6n) of corners x [m] (n = 3 or 4), of a material in the axes of the mesh, of thickness and offset of the middle surface from the corners along e_3 [m].  Returns the smallest det J; where it is not positive K_e is meaningless.
double shell_stiffness(const NodePositions& x, const Material& material, double thickness, double offset,
                       Eigen::MatrixXd& K_e);

/// m_e (n x n) for displacements: consistent, N as in the plane; lumped: diagonal.  Rotary inertia is not in it
/// (shell_skins.hpp).  Returns the smallest det J.
double shell_mass(const NodePositions& x, double density, double thickness, MassKind kind,
                  Eigen::MatrixXd& m_e);

/// Stresses at the corners on both sides of the shell: 6 x 6n operators, rows (xx, yy, zz, xy, yz, zx) in the axes of the mesh.
struct ShellStress {
  std::vector<Eigen::MatrixXd> top, bottom;  ///< one for each corner
};
ShellStress shell_stress(const NodePositions& x, const Material& material, double thickness, double offset);

}  // namespace flexura::reduce
