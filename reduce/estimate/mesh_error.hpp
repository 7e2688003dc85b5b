// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/part.hpp"
#include "reduce/linalg/progress.hpp"

/// What the mesh leaves of the energy.
///
/// For a shape u_h of the mesh and the exact u that it stands for, the difference e has the energy |e|^2, estimated
/// with recovered stresses s* (stress_recovery.hpp) in place of the exact ones (O. C. Zienkiewicz, J. Z. Zhu, Int. J.
/// Numer. Meth. Eng. 24 (1987), 337).  As a matrix on all shapes T of a superelement,
///
///     E_ij = integral (s*_i - s_i)^T C (s*_j - s_j) dV,    C = D^-1,
///
/// it gives, since a conforming mesh is too stiff by just this energy (Galerkin orthogonality):
///  - the eigenvalue of a mode y of whatever the body is part of:  lambda_h - lambda = y^T E y  (y^T M y = 1; G.
///    Strang, G. J. Fix, An Analysis of the Finite Element Method, chapter 6),
///  - the static stiffness between interfaces:  K_h - K = E on the constraint modes,
///  - the compliance under a load p:  delta C = C_h E C_h.
/// Rigid motions have no part in it.
namespace flexura::reduce {

/// E, n x n [J per unit of the shapes squared], positive semidefinite; empty where the part has no cells (matrices of
/// another program): then it is not known.
Eigen::MatrixXd mesh_error(const Part& part, const Eigen::MatrixXd& T, const linalg::Progress& progress);

}  // namespace flexura::reduce
