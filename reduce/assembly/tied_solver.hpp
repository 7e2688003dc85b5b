// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <stdexcept>

#include "reduce/assembly/model_factor.hpp"

/// Solves with K_ii of a tied model, averaging ties included:
///
///     K_ii U + A^T mu = F,     A U = g
///
/// K_ii alone is singular where only averages hold the body.  So weak springs s at the model's pins are added
/// before the factorisation, K' = K_ii + E s E^T, and taken out again exactly, with w = s E^T U the springs'
/// forces:
///
///     [ K'    V ] [ U ]   [ F ]                 V = [ A^T  -E ]
///     [ V^T   S ] [ y ] = [ g ],  y = (mu, w),  S = diag(0, 1/s)
///
/// U = K'^-1 (F - V y),  (V^T K'^-1 V - S) y = V^T K'^-1 F - g.  Without averages this is K_ii^-1 F.
namespace flexura::reduce {

/// The stiffness matrix is singular although the interfaces hold the body.
struct SingularStiffness : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

class TiedSolver {
 public:
  /// Factorises.  The model must outlive the solver.  Vectors are by the model's rows, and what it does is collective where
  /// a team shares the model.  A mechanism (two solids that share a single node, say)
  /// is refused with std::invalid_argument that names node and direction.
  explicit TiedSolver(const TiedModel& model, const linalg::Progress& progress = {},
                      const linalg::FactorStorage& storage = {});

  /// U for A U = 0 (fixed interfaces), all columns together.
  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& F) const;

  struct Solution {
    Eigen::MatrixXd U;   ///< n_rows x k
    Eigen::MatrixXd mu;  ///< n_a x k
  };
  /// Prescribed averages g (n_a x k), with iterative refinement until the residual is round-off.
  Solution solve_refined(const Eigen::Ref<const Eigen::MatrixXd>& F,
                         const Eigen::Ref<const Eigen::MatrixXd>& g) const;

  /// Takes away from R (n_rows x k) what is a combination of the rows of A: the reactions of fixed averages.
  void remove_reactions(Eigen::MatrixXd& R) const;

  /// Writes PETSc's report of the solver of K' to its viewer.
  void view(_p_PetscViewer* viewer) const { factor_.view(viewer); }

  const TiedModel& model() const { return model_; }
  const ModelFactor& factor() const { return factor_; }
  const std::vector<int>& order() const { return factor_.order(); }
  const linalg::FactorFigures& figures() const { return factor_.figures(); }

 private:
  Solution solve_once(const Eigen::Ref<const Eigen::MatrixXd>& F,
                      const Eigen::Ref<const Eigen::MatrixXd>& g) const;

  const TiedModel& model_;
  Eigen::VectorXd springs_;
  ModelFactor factor_;
  Eigen::MatrixXd Z_;  ///< K'^-1 V
  Eigen::PartialPivLU<Eigen::MatrixXd> small_;
  Eigen::PartialPivLU<Eigen::MatrixXd> AAt_;
};

}  // namespace flexura::reduce
