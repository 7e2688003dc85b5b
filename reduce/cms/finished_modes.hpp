// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/cms/craig_bampton.hpp"

/// Superelements of mode vectors that another program has computed (UM's road from ANSYS): free modes, static
/// modes, whatever spans the reduced space.
///
///     W = [ R  V ],   R the six rigid motions,   K_W = diag(0, K_V),   M_W = W^T M W
///
/// and B = the interface dofs of W bring it to the form of shape_change.hpp: orthonormal, the rigid motions
/// exact and taken out of all others, what depends on others dropped.  M is the part's mass matrix, since the
/// inertia integrals need the mass of each node and not only V^T M V.
namespace flexura::reduce {

struct FinishedModes {
  Eigen::MatrixXd
      V;  ///< 3 n x m, displacements of the part's nodes, less those of Part::followers [m per unit]
  Eigen::MatrixXd rotations =
      {};                  ///< 3 n x m, of the same nodes [rad per unit], zero where one has none; or empty
  Eigen::MatrixXd K;       ///< m x m, V^T K V
  Eigen::MatrixXd M;       ///< m x m, V^T M V as the other program has it, for comparison; or empty
  Eigen::MatrixXd D;       ///< m x m, V^T D V; or empty
  Eigen::MatrixXd stress;  ///< 6 n x m, rows xx, yy, zz, xy, yz, zx of each node [Pa per unit]; or empty
};

/// `part` gives nodes, interfaces and, in `matrices`, the mass, with points that follow the nodes (rotary inertia: take_in() of reduce/part).  An
/// interface of one node, or of nodes that a rigid tie holds, turns with the rotations of its nodes; without any it turns as
/// their displacements say.  Of the options the loads, the shapes' and
/// the stresses' nodes are read.  std::invalid_argument where
///  - the vectors do not move all interface dofs independently,
///  - points follow rotations and there are none,
///  - they bend an interface that is tied rigidly (an average takes any),
///  - K contradicts the vectors: a combination that moves nothing, or rigidly, has stiffness (a spring to the
///    ground, columns in another order).
/// Needs a linalg::Session.
Reduction reduce_finished_modes(const Part& part, const FinishedModes& modes,
                                const ReductionOptions& options);

}  // namespace flexura::reduce
