// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Only for the .cpp files of this folder that see PETSc.
#include <petscksp.h>

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "reduce/linalg/dense/factor_figures.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/factor/fronts_hints.hpp"

namespace flexura::linalg {

/// X = A^-1 B by PETSc's KSP and PC, which read the user's options (petsc_options.hpp): by default KSPPREONLY,
/// PCCHOLESKY and the solver package fronts.
class DirectSolver {
 public:
  struct Settings {
    bool definite = true;
    bool count_negative = false;            ///< inertia is wanted: a factor L D L^T whatever the options say
    std::span<const int> group_begin = {};  ///< as in cholesky.hpp
    std::span<const int> doubled = {};
    FrontsHints hints = {};
  };
  /// Factorises.
  DirectSolver(const SymmetricMatrix& A, Settings settings);
  ~DirectSolver();
  DirectSolver(const DirectSolver&) = delete;
  DirectSolver& operator=(const DirectSolver&) = delete;

  /// Why the matrix has no factor that can be used.
  struct Failure {
    bool failed = false;
    int row = -1;  ///< where it was noticed; -1: the package does not say
  };
  const Failure& failure() const { return failure_; }

  /// X has the size of B.  std::runtime_error where an iterative method that the user has chosen does not
  /// converge.
  void solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> X) const;

  void view(PetscViewer viewer) const;

  int size() const { return n_; }
  int n_negative() const;
  const std::vector<int>& order() const;  ///< empty where another package than fronts has factorised
  const FactorFigures& figures() const { return figures_; }

 private:
  void destroy();
  void create_matrix(const SymmetricMatrix& A, const Settings& settings);
  void create_solver(const Settings& settings);
  void set_up();
  void test(const UpperCsr& A, bool definite);

  int n_ = 0;
  std::shared_ptr<const void> numbers_;  // of A, of which mat_ is a view
  std::vector<double> values_;           // in place of A's where entries are doubled
  Mat mat_ = nullptr;
  KSP ksp_ = nullptr;
  Mat factor_ = nullptr;  // the PC's; null where it has none
  Failure failure_;
  FactorFigures figures_;
  std::vector<int> no_order_;
};

}  // namespace flexura::linalg
