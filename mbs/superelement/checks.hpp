// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/superelement/file.hpp"

namespace flexura::superelement {

/// validate() of what is present: a reader that left the inertia integrals in the file checks the rest.
void validate_parts(const Superelement& se, const Parts& present);

/// As rigid_motions(), the rotations about the point p_BoP_B instead of Bo.
Eigen::MatrixXd rigid_motions_about(const Superelement& se, const Eigen::Vector3d& p_BoP_B);

}  // namespace flexura::superelement
