// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "mbs/bodies/body_node.hpp"
#include "mbs/bodies/modal_data.hpp"
#include "mbs/bodies/particle_acceleration.hpp"
#include "mbs/bodies/stiffening_loads.hpp"

namespace flexura::mbs {

/// How the superelement gives way beyond the modes Y of a body, at rest with all that loads it:
///
///     u_left = G (sum of the nodes' rows^T F + P f - inertia - K_G Y s) - Y Omega^-2 Y^T (inertia that the coupling drops),
///     G = X Lambda^-1 X^T - Y Omega^-2 Y^T
///
/// X, Lambda all its eigenmodes, K_G = sum of l_k K_0,k the geometric stiffness, F the force and moment on each node, f the factors of the load cases, the inertia that of
/// particle_acceleration.hpp.  So sections and stresses are in balance with the loads whatever modes are kept and whatever
/// inertia the equations of motion know, and follow as fast as the left-out modes do.  (Mode acceleration: R. R. Craig,
/// A. J. Kurdila, Fundamentals of Structural Dynamics, 2006, 11.4.)
///
/// X moves as Y does, in the body's frame: loads that hold each other in balance only where the body is as deformed, or
/// with the acceleration of a one-way body's deformation, are then missing at the held directions alone, with every mode
/// and with few; in other axes they would load all of the body.
struct LeftOutModes {
  Eigen::MatrixXd of_nodes;              ///< n_se x 6 nodes: force, then moment of each, in B
  Eigen::MatrixXd of_loads;              ///< n_se x load cases
  Eigen::MatrixXd of_acceleration;       ///< n_se x 12
  Eigen::MatrixXd of_deformation;        ///< n_se x 9 m
  Eigen::MatrixXd dropped_acceleration;  ///< n_se x 12; both empty with full coupling
  Eigen::MatrixXd dropped_deformation;   ///< n_se x 9 m
  /// n_se x m for each of the stiffening loads l: what the geometric stiffness asks of the deformation that is kept; empty
  /// without it.
  std::vector<Eigen::MatrixXd> of_stiffening;
};

/// Empty where no mode is left out and the coupling is full.  `nodes` as in `body`; none where other places of it are loaded, too:
/// then of the inertia that the coupling drops alone.
std::optional<LeftOutModes> left_out_modes(const superelement::Superelement& se, const ModalData& body,
                                           const std::vector<BodyNode>& nodes);

/// The inertia, as c and B, that equations with less than full coupling leave out.
ParticleAcceleration dropped_inertia(const BodyMotion& motion, int m, Coupling coupling);

}  // namespace flexura::mbs
