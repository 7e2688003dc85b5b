// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/shifted_solver.hpp"

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

ShiftedSolver::ShiftedSolver(const TiedModel& model, double omega2, std::vector<int> order,
                             const linalg::FactorStorage& storage)
    : model_(model),
      factor_(ModelFactor::shifted(model, -omega2, std::move(order), storage)),
      n_below_(factor_.n_negative()) {
  const auto& A = model.A();
  if (A.rows() == 0) return;
  Z_ = factor_.solve(Eigen::MatrixXd(A.transpose()));
  const Eigen::MatrixXd S = model.sum(A * Z_);
  small_.compute(S);
  const Eigen::VectorXd values = linalg::symmetric_eigen(-0.5 * (S + S.transpose())).values;
  n_below_ += static_cast<int>((values.array() < 0.0).count()) - static_cast<int>(A.rows());
}

Eigen::MatrixXd ShiftedSolver::solve(const Eigen::Ref<const Eigen::MatrixXd>& F) const {
  Eigen::MatrixXd U = factor_.solve(F);
  if (Z_.cols() > 0) U.noalias() -= Z_ * small_.solve(model_.sum(model_.A() * U));
  return U;
}

}  // namespace flexura::reduce
