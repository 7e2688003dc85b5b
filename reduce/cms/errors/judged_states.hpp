// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/cms/result/mesh_share.hpp"
#include "reduce/cms/shapes/basis.hpp"

/// The judged motions as displacements of nodes.  All is collective where a team shares the model.
namespace flexura::reduce {

/// Rank 0's motions, for all ranks to the bit: Y, eigenvalues and how many modes.
void share_motions(const TiedModel& model, JudgedMotions& motions);

/// What the modes left out add to free modes of the reduced body, lambda F_rs Mhat u_b, F_rs = K_ii^-1 - Phi Omega^-2 Phi^T (mode
/// acceleration: N. E. Hansteen, K. Bell, Earthq. Eng. Struct. Dyn. 7 (1979) 325), exact to (lambda / omega_dropped^2)^2; into
/// the displacements U of the nodes here.  The estimate of the mesh's error would take what the reduction lacks for the mesh's.
/// `answer`: K_ii^-1 Mhat.
void add_dropped(const TiedModel& model, const Basis& basis, const Eigen::MatrixXd& Mhat,
                 const Eigen::MatrixXd& answer, const JudgedMotions& motions, Eigen::MatrixXd& U);

/// Of displacements of the nodes here those of all nodes of the part, on rank 0; nothing on the others.
Eigen::MatrixXd on_all_nodes(const TiedModel& model, Eigen::MatrixXd U);

}  // namespace flexura::reduce
