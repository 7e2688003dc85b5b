// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/fixed_interface.hpp"

#include <memory>

#include "reduce/assembly/shifted_solver.hpp"

namespace flexura::reduce {

using Eigen::MatrixXd;

linalg::EigenProblem interior_problem(const TiedModel& model) {
  linalg::EigenProblem problem;
  problem.n = model.n_rows();
  if (const PartShare* share = model.share()) {
    problem.rank = share->team->rank();
    problem.sum = [share](double* values, Eigen::Index count) {
      share->team->sum({values, static_cast<std::size_t>(count)});
    };
  }
  problem.multiply_K = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { model.multiply_K(X, Y); };
  problem.multiply_magnitudes = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) {
    model.multiply_magnitudes(X, Y);
  };
  problem.multiply_M = [&model](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { model.multiply_M(X, Y); };
  return problem;
}

linalg::EigenProblem fixed_interface_problem(const TiedModel& model, const TiedSolver& solver,
                                             const linalg::FactorStorage& storage) {
  linalg::EigenProblem problem = interior_problem(model);
  problem.n_free = model.n_i() - static_cast<int>(model.A().rows());
  problem.solve = [&solver](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { Y = solver.solve(X); };
  problem.project = [&solver](MatrixXd& R) { solver.remove_reactions(R); };
  problem.view = [&solver](_p_PetscViewer* viewer) { solver.view(viewer); };
  problem.shifted = [&model, &solver, storage](double sigma) {
    auto shifted = std::make_shared<const ShiftedSolver>(model, sigma, solver.order(), storage);
    return linalg::EigenProblem::Shifted{
        [shifted](const Eigen::Ref<const MatrixXd>& X, MatrixXd& Y) { Y = shifted->solve(X); },
        shifted->n_below()};
  };
  problem.factor_operations = solver.figures().flops;
  problem.solve_operations = 4.0 * solver.figures().nonzeros;
  return problem;
}

}  // namespace flexura::reduce
