// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/fixed_interface.hpp"

namespace flexura::reduce {

using Eigen::MatrixXd;

linalg::EigenProblem fixed_interface_problem(const TiedModel& model, const TiedSolver& solver) {
  linalg::EigenProblem problem;
  problem.n = model.n_i();
  problem.n_free = model.n_i() - static_cast<int>(model.A().rows());
  problem.solve = [&solver](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { Y = solver.solve(X); };
  problem.multiply_K = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    model.K_ii().multiply(X, Y);
  };
  problem.multiply_magnitudes = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    model.K_ii().multiply_magnitudes(X, Y);
  };
  problem.multiply_M = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    model.matrices().multiply_M_ii(X, Y);
  };
  problem.project = [&solver](MatrixXd& R) { solver.remove_reactions(R); };
  problem.view = [&solver](_p_PetscViewer* viewer) { solver.view(viewer); };
  return problem;
}

}  // namespace flexura::reduce
