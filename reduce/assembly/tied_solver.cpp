// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/tied_solver.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "reduce/linalg/factor/cholesky.hpp"

namespace flexura::reduce {
namespace {

// The pins' springs go onto the diagonal for the factorisation only.
ModelFactor factorise(const TiedModel& model, const Eigen::VectorXd& springs,
                      const linalg::Progress& progress, const linalg::FactorStorage& storage) {
  linalg::report(progress, "factorisation", 0.0);
  try {
    ModelFactor factor = ModelFactor::stiffness(model, springs, storage);
    linalg::report(progress, factor.figures().in_file ? "factorisation (kept in a file)" : "factorisation",
                   1.0);
    return factor;
  } catch (const linalg::SingularMatrix& singular) {
    throw SingularStiffness(fmt::format(
        "the stiffness matrix is singular although the interfaces hold the body: a part of it can move "
        "without strain, noticed at {}; look for solids that touch in a single node or edge, hinges with an "
        "interface on one side alone (add one beyond), and C3D20R in a single row (take two across)",
        singular.dof >= 0
            ? model.motions().describe_dof(singular.dof)
            : "a place that one process alone (without mpirun) with the solver package fronts would name"));
  }
}

// V = [A^T, -E].
Eigen::MatrixXd border_columns(const TiedModel& model) {
  const auto& A = model.A();
  const auto& pins = model.pins();
  const Eigen::Index n_a = A.rows(), n_p = static_cast<Eigen::Index>(pins.size());
  Eigen::MatrixXd V = Eigen::MatrixXd::Zero(model.n_rows(), n_a + n_p);
  V.leftCols(n_a) = A.transpose();
  for (Eigen::Index p = 0; p < n_p; ++p)
    if (pins[p] != TiedModel::kElsewhere) V(pins[p], n_a + p) = -1.0;
  return V;
}

}  // namespace

TiedSolver::TiedSolver(const TiedModel& model, const linalg::Progress& progress,
                       const linalg::FactorStorage& storage)
    : model_(model), springs_(model.pin_stiffness()), factor_(factorise(model, springs_, progress, storage)) {
  const auto& A = model.A();
  const auto& pins = model.pins();
  const Eigen::Index n_a = A.rows(), n_p = static_cast<Eigen::Index>(pins.size());
  if (n_a + n_p == 0) return;
  const Eigen::MatrixXd V = border_columns(model);
  Z_ = factor_.solve(V);
  Eigen::MatrixXd small = model.sum(V.transpose() * Z_);
  for (Eigen::Index p = 0; p < n_p; ++p) small(n_a + p, n_a + p) -= 1.0 / springs_(p);
  small_.compute(small);
  if (n_a > 0) AAt_.compute(model.sum(Eigen::MatrixXd(A * A.transpose())));
}

TiedSolver::Solution TiedSolver::solve_once(const Eigen::Ref<const Eigen::MatrixXd>& F,
                                            const Eigen::Ref<const Eigen::MatrixXd>& g) const {
  Solution solution{factor_.solve(F), {}};
  if (Z_.cols() == 0) return solution;
  const auto& A = model_.A();
  const auto& pins = model_.pins();
  Eigen::MatrixXd y = Eigen::MatrixXd::Zero(Z_.cols(), F.cols());
  y.topRows(A.rows()) = A * solution.U;
  for (std::size_t p = 0; p < pins.size(); ++p)
    if (pins[p] != TiedModel::kElsewhere)
      y.row(A.rows() + static_cast<Eigen::Index>(p)) = -solution.U.row(pins[p]);
  y = model_.sum(std::move(y));
  y.topRows(A.rows()) -= g;
  y = small_.solve(y).eval();
  solution.U.noalias() -= Z_ * y;
  solution.mu = y.topRows(A.rows());
  return solution;
}

Eigen::MatrixXd TiedSolver::solve(const Eigen::Ref<const Eigen::MatrixXd>& F) const {
  return solve_once(F, Eigen::MatrixXd::Zero(model_.A().rows(), F.cols())).U;
}

TiedSolver::Solution TiedSolver::solve_refined(const Eigen::Ref<const Eigen::MatrixXd>& F,
                                               const Eigen::Ref<const Eigen::MatrixXd>& g) const {
  const auto& A = model_.A();
  Solution solution = solve_once(F, g);
  Eigen::MatrixXd KU;
  for (int step = 0; step < 2; ++step) {
    model_.multiply_K(solution.U, KU);
    Eigen::MatrixXd residual = F - KU;
    if (A.rows() > 0) residual -= A.transpose() * solution.mu;
    const Eigen::MatrixXd gap =
        A.rows() > 0 ? Eigen::MatrixXd(g - model_.sum(A * solution.U)) : Eigen::MatrixXd(g);
    const Solution correction = solve_once(residual, gap);
    solution.U += correction.U;
    if (A.rows() > 0) solution.mu += correction.mu;
    // One step brings the error to a few ulps unless the matrix is very badly conditioned; then a second one.
    if (model_.norm(correction.U) < 1e-12 * model_.norm(solution.U)) break;
  }
  return solution;
}

void TiedSolver::remove_reactions(Eigen::MatrixXd& R) const {
  const auto& A = model_.A();
  if (A.rows() > 0) R -= A.transpose() * AAt_.solve(model_.sum(A * R));
}

}  // namespace flexura::reduce
