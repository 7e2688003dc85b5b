// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "reduce/linalg/eigen/eigen_problem.hpp"

/// Shapes beside the normal modes: answers of the interior to what will act on it.
///
/// Frequency response modes (SP): the motion under unit loads at the interface that vary with Omega,
///
///     (K - Omega^2 M) u = p,     interior:  u_i = Psi u_b + X u_b,
///     X = Omega^2 (K_ii - Omega^2 M_ii)^-1 Mhat,   Mhat = M_ib + M_ii Psi,
///
/// so X (whose interface dofs are zero) with the constraint modes spans the exact answer at Omega.  What of X
/// lies in the kept normal modes is there already; in the rest, whose eigenvalues begin at omega_c^2, the
/// series X = sum_j (Omega^2 K_ii^-1 M_ii)^j Omega^2 K_ii^-1 Mhat converges like (Omega / omega_c)^(2 j).
/// Omega = 0 gives K_ii^-1 Mhat: the answer to slow acceleration of the interface.
///
/// Load shapes: K_ii^-1 f_i, the interior's answer to a load case.
namespace flexura::reduce {

/// Shapes with zero interface dofs and their names.
struct ExtraShapes {
  Eigen::MatrixXd X;  ///< n_i x k
  Eigen::VectorXd mass,
      energy;  ///< k: x^T M x and x^T K x of the answers, their part in the normal modes included
  std::vector<std::string> names;
};

/// Those of both, side by side.
void add_to(ExtraShapes& all, const ExtraShapes& more);

/// The answers X (n_i x k) with their sizes.
ExtraShapes whole_shapes(const linalg::EigenProblem& problem, Eigen::MatrixXd X,
                         std::vector<std::string> names);

/// The response modes for each interface dof.  `Mhat` n_i x n_b; `names` of the interface dofs.  Throws
/// std::invalid_argument for frequencies above 0.8 of the first one that the pairs leave out.
ExtraShapes response_shapes(const linalg::EigenProblem& problem, const linalg::EigenPairs& pairs,
                            const Eigen::MatrixXd& Mhat, double omega, const std::vector<std::string>& names);

/// Takes the normal modes out of the extra shapes, drops what depends on earlier ones (less than kDependent of the
/// answer is left, in mass and in strain energy) and appends the rest to the pairs as vectors with phi^T M phi = 1, phi^T K phi =
/// diag(omega2).  Returns the names of the dropped.  The pairs must be exact modes, so it is called once, with
/// the shapes of all loads and frequencies.
std::vector<std::string> append_shapes(const linalg::EigenProblem& problem, linalg::EigenPairs& pairs,
                                       const ExtraShapes& extra);

}  // namespace flexura::reduce
