// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mbs/bodies/body_node.hpp"
#include "mbs/bodies/modal_data.hpp"

namespace flexura::mbs {

/// How the superelement gives way beyond the modes Y that a body has of it, at rest with all that loads it:
///
///     u_left = G (sum of the nodes' rows^T F + P f - inertia),     G = X Lambda^-1 X^T - Y Omega^-2 Y^T
///
/// X, Lambda all its eigenmodes, F the force and moment on each node, f the factors of the load cases, the inertia that of
/// particle_acceleration.hpp.  So sections and stresses are in balance with the loads whatever modes are kept, and follow
/// as fast as the left-out ones do.  (Mode acceleration: R. R. Craig, A. J. Kurdila, Fundamentals of Structural Dynamics,
/// 2006, 11.4.)
struct LeftOutModes {
  Eigen::MatrixXd of_nodes;         ///< n_se x 6 nodes: force, then moment of each, in B
  Eigen::MatrixXd of_loads;         ///< n_se x load cases
  Eigen::MatrixXd of_acceleration;  ///< n_se x 12
  Eigen::MatrixXd of_deformation;   ///< n_se x 9 m
};

/// Empty where no mode is left out.  `nodes` as in `body`.
std::optional<LeftOutModes> left_out_modes(const superelement::Superelement& se, const ModalData& body,
                                           const std::vector<BodyNode>& nodes);

}  // namespace flexura::mbs
