// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/cms/result/options.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/cms/shapes/basis.hpp"
#include "reduce/cms/shapes/interface_modes.hpp"

/// From a basis to the superelement's matrices: K_se = T^T K T, M_se = T^T M T, and what else is seen through T.
namespace flexura::reduce {

/// T on all nodes here, 3 n_nodes x (n_b + n_q): the one dense array of that size.  Columns: U_b, Phi, interface modes.
Eigen::MatrixXd shapes_on_nodes(const TiedModel& model, const Basis& basis, const InterfaceModes& faces);

/// Matrices, inertia integrals, interfaces, and the shapes at the nodes asked for (numbers of the whole part, on rank 0 of a
/// team).  `part` is `whole` with its elastic ties rigid.
void project(const Part& whole, const Part& part, const TiedModel& model, const Basis& basis,
             const InterfaceModes& faces, const Eigen::MatrixXd& T, const ReductionOptions& options,
             Reduction& reduction);

/// Load cases on the shapes.
void project_loads(const TiedModel& model, const Eigen::MatrixXd& T, const ReductionOptions& options,
                   Reduction& reduction);

/// reduction.D_se (dampers.hpp), of a part here; collective.
void project_damping(const Part& part, const TiedModel& model, const Basis& basis, const Eigen::MatrixXd& T,
                     Reduction& reduction);

/// The shapes' motions of all nodes, on rank 0 of a team.
NodeMotions all_node_motions(const Part& whole, const TiedModel& model, const Basis& basis,
                             const Eigen::MatrixXd& T);

/// Motions of Part::bars by the shapes, and where the shapes lack `left_out` (n_i x k, the interfaces at rest; may be empty).  Not
/// of a team.
BarMotions bar_motions(const Part& part, const TiedModel& model, const Basis& basis, const Eigen::MatrixXd& T,
                       const Eigen::MatrixXd& left_out);

/// 6 n_s x n: stresses of the shapes at the options' stress nodes; on rank 0 of a team, which knows the whole part.
Eigen::MatrixXd stress_modes(const Part& whole, const Part& part, const TiedModel& model, const Basis& basis,
                             const Eigen::MatrixXd& T, const ReductionOptions& options);

/// The same of deformations X of the interior (n_i x k), the interfaces at rest; not of a team.
Eigen::MatrixXd stress_of_interior(const Part& part, const TiedModel& model, const Eigen::MatrixXd& X,
                                   const ReductionOptions& options);

/// 6 n_s x loads: what preloads among the options' loads add there; empty where none is one.
Eigen::MatrixXd stress_of_preloads(const Part& part, const ReductionOptions& options);

}  // namespace flexura::reduce
