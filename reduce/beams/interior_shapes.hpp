// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/beams/numbering.hpp"
#include "reduce/beams/statics.hpp"
#include "reduce/cms/result/options.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"

namespace flexura::reduce {

/// A structure with its interfaces at rest.
struct BeamInterior {
  const Structure& structure;
  const std::vector<BeamInterface>& interfaces;
  const Numbering& numbering;
  const linalg::CholeskyFactor& factor;  ///< of K.ii
  const SplitMatrix &K, &M;
  const Eigen::MatrixXd &Psi, &R_b,
      &R_i;  ///< n_i x n_b; rigid motions about Bo of the dofs, n_b x 6 and n_i x 6

  /// Displacements of all dofs (n_dofs x k) by those of the interfaces (n_b x k) and of the interior (n_i x k).
  Eigen::MatrixXd on_all_dofs(const Eigen::MatrixXd& u_b, const Eigen::MatrixXd& u_i) const;
};

/// The shapes with the interfaces at rest that the options ask for, phi^T M phi = 1, phi^T K phi = omega2: normal modes by number,
/// frequency, accuracy or effective mass, with response modes; Craig and Chang's, which with the constraint modes span the free
/// body's modes and inertia-relief attachment modes (craig_chang.hpp); none (Guyan).  Static answers to preloads among the cases
/// join them.  omega2_next: of normal modes the first left out, infinite where there is none.  Needs a linalg::Session.
linalg::EigenPairs interior_shapes(const BeamInterior& interior, const ReductionOptions& options,
                                   const std::vector<LoadCase>& cases, ReductionReport& report);

}  // namespace flexura::reduce
