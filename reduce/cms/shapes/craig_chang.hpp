// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/tied_solver.hpp"
#include "reduce/cms/result/options.hpp"

/// Free-free normal modes and inertia-relief attachment modes (R. R. Craig, C.-J. Chang, NASA CP-2001, 1976;
/// W. C. Hurty's and S. Rubin's residual flexibility, AIAA J. 13 (1975), 995).
///
///     K phi = omega^2 M phi                       of the free body, six rigid modes R among them
///     K a_k = p_k - M R (R^T M R)^-1 R^T p_k      p_k a unit load on interface dof k, balanced by inertia
///
/// a_k less its share of the kept phi is the residual flexibility; the space is the same.  6 rigid, n free
/// and n_b attachment modes span what n_b constraint modes, n free modes and the six answers to rigid
/// acceleration do.  With the interface held there is one factor for all: writing a motion as u = Psi u_b + w
/// with w = 0 at the interface, K is block diagonal,
///
///     K_bb u_b = p_b + Psi^T p_i,      K_ii w = p_i,
///
/// and the six right-hand sides M R serve all attachment modes.
namespace flexura::reduce {

/// What is to be known of the held part before the free one is factorised.
struct HeldAnswers {
  double omega2_first = 0.0;  ///< the first fixed-interface eigenvalue [rad^2/s^2]
  Eigen::MatrixXd R, M_R;     ///< rigid motions of the nodes here and their inertia forces
  Eigen::MatrixXd g_i, g_b;   ///< M R on the dofs
  Eigen::MatrixXd answer;     ///< K_ii^-1 g_i
};
HeldAnswers held_answers(const TiedModel& model, const TiedSolver& solver, const linalg::Progress& progress);

/// Vectors u = Psi c_b + w that span the space: rigid modes, free modes, attachment modes, in this order.
struct CraigChangSpan {
  Eigen::MatrixXd W;     ///< n_rows x m
  Eigen::MatrixXd C_b;   ///< n_b x m
  Eigen::MatrixXd K, M;  ///< m x m
  int first_attachment = 0;
  Eigen::VectorXd residual, round_off;  ///< of the free modes
};

/// `Psi`, `K_bb` as in stiffening_terms().  options.n_modes elastic free modes, or all up to
/// options.omega_max.  `part` is read on the leading rank alone; the small matrices are the same on all.
CraigChangSpan craig_chang_span(const Part& part, const TiedModel& model, const HeldAnswers& held,
                                const Eigen::MatrixXd& Psi, const Eigen::MatrixXd& K_bb,
                                const ReductionOptions& options);

}  // namespace flexura::reduce
