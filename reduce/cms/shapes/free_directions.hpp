// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/cms/result/reduction.hpp"

namespace flexura::reduce {

/// Directions that an interface does not keep move by the part's own deformation: by their rows of `motion` (6 x n, (u, theta) of
/// the interface's node by the shapes).  Left out are those that the node does not have (the rotation of a single node of a
/// solid): their rows are no rigid motion where the boundary moves as one, `R_b` (n_b x 6).
void set_free_motion(ReducedInterface& interface, const Eigen::MatrixXd& motion, const Eigen::MatrixXd& R_b);

}  // namespace flexura::reduce
