// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/linalg/dense/factor_figures.hpp"
#include "reduce/linalg/factor/factor_store.hpp"

struct _p_PetscViewer;  // PETSc's, which only reduce/linalg sees

/// The stiffness matrix of a tied model, factorised: the one place that knows whether a process works alone
/// (its own multifrontal method on all its cores) or is one of a team (MUMPS over all ranks).
namespace flexura::reduce {

class ModelFactor {
 public:
  struct Impl;
  /// K_ii with its diagonal doubled at the model's pins, to `springs`.  linalg::SingularMatrix (with dof -1 where a team
  /// does not know it) where it is not positive definite to round-off.
  static ModelFactor stiffness(const TiedModel& model, const Eigen::VectorXd& springs,
                               const linalg::FactorStorage& storage = {});
  /// K_ii + shift M_ii, indefinite, for its inertia; in `order`, or nested dissection where that is empty.
  /// std::runtime_error where the shift is all but an eigenvalue.
  static ModelFactor shifted(const TiedModel& model, double shift, std::vector<int> order = {},
                             const linalg::FactorStorage& storage = {});
  ~ModelFactor();
  ModelFactor(ModelFactor&&) noexcept;
  ModelFactor& operator=(ModelFactor&&) noexcept;

  Eigen::MatrixXd solve(const Eigen::Ref<const Eigen::MatrixXd>& B) const;
  /// Writes PETSc's report of the solver to its viewer.
  void view(_p_PetscViewer* viewer) const;
  int n_negative() const;                 ///< pivots
  const std::vector<int>& order() const;  ///< empty where a team has factorised
  const linalg::FactorFigures& figures() const;

 private:
  explicit ModelFactor(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::reduce
