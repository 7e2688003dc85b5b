// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/superelement/file.hpp"

namespace flexura::superelement {

/// validate() of what is present: a reader that left the inertia integrals in the file checks the rest.
void validate_parts(const Superelement& se, const Parts& present);

/// As rigid_motions(), the rotations about the point p_BoP_B instead of Bo.
Eigen::MatrixXd rigid_motions_about(const Superelement& se, const Eigen::Vector3d& p_BoP_B);

/// What entries of A (n x n: K_se, M_se or D_se) on the diagonal come to, by the unit of the dof: the largest one of a
/// displacement, of a rotation, of a mode.  Where the interfaces' own motion does not show in A (a straight rod's stiffness, of an
/// interface across it), a rotation is as large as a displacement times the square of the body's length, and a displacement as a
/// mode times the mass.
Eigen::VectorXd unit_sizes(const Superelement& se, const Eigen::MatrixXd& A);

}  // namespace flexura::superelement
