// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/tied_solver.hpp"
#include "reduce/cms/result/options.hpp"
#include "reduce/linalg/dense/progress.hpp"

/// Interface reduction: characteristic constraint modes (M. P. Castanier, Y.-C. Tan, C. Pierre, AIAA J. 39
/// (2001), 1182).
///
/// Every displacement w of the nodes of elastic ties, thousands perhaps, would be a boundary dof.  Of this
/// motion the six rigid ones of each interface stay, exactly, as the dofs of its node; the rest, A w = 0 with
/// the mean A of average.hpp, is described by the lowest eigenvectors of the boundary's own condensed pencil,
///
///     K^ w = omega^2 M^ w,   K^ = K_ff - K_fr K_rr^-1 K_rf,   M^ = L^T M L,   L w = (w, -K_rr^-1 K_rf w),
///
/// f the nodes of the ties, r all other interior dofs; other interfaces are held.  Loads on an interface node
/// act through A, so that all interface modes together are the averaging tie, none of them the rigid one.
///
/// K^ and M^ are never formed.  With the factors of both ties, `soft` (averages, f free) and `stiff` (f
/// rigid, hence r alone), a load z on all interior dofs gives, as static condensation has it,
///
///     L K^^-1 L^T z = K_soft^-1 z - (0, K_rr^-1 z_r),
///
/// so that Lanczos works on L w, with the mesh's sparse K and M for scalar products.  Costs two solves for
/// each vector, whatever the number of interface nodes.
namespace flexura::reduce {

bool has_elastic_ties(const Part& part);
/// The part with its elastic ties rigid.
Part with_rigid_faces(Part part);

struct InterfaceModes {
  Eigen::MatrixXd U;       ///< 3 n_nodes x k: L w on all nodes here, mass-orthonormal
  Eigen::MatrixXd K_bw;    ///< n_b x k: stiffness in common with the constraint modes of the rigid ties
  Eigen::MatrixXd K_ww;    ///< k x k
  Eigen::VectorXd omega2;  ///< k [rad^2/s^2]
  int n_face = 0;          ///< dofs that they stand for
  /// Greatest relative error of the static stiffness between the interfaces, against the averaging tie, which
  /// is what all interface modes would give; -1 for a single interface, between which nothing can be held.
  double stiffness_error = -1.0;
};

/// `stiff` and `soft` are models of with_rigid_faces(part) and of the part itself, or of shares of both that are cut alike
/// (share_retied()): then it is collective; `Psi` and `K_bb` the constraint modes and condensed stiffness of `stiff`.
/// std::invalid_argument where an elastic tie does not retain all six directions, and for an accuracy that cannot be reached or
/// measured.
InterfaceModes interface_modes(const TiedSolver& soft, const TiedSolver& stiff, const Eigen::MatrixXd& Psi,
                               const Eigen::MatrixXd& K_bb, const InterfaceModesRequest& request,
                               const linalg::Progress& progress);

}  // namespace flexura::reduce
