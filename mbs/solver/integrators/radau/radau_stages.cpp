// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/radau/radau_stages.hpp"

#include <Eigen/LU>

namespace flexura::mbs {

RadauStages::RadauStages(const Equations& eq, const RadauTableau& tableau, const State& start) {
  for (auto& stage : stages_) stage = std::make_unique<Stage>(eq, start);
  // Crout's factors of A.
  const Eigen::Matrix3d A = tableau.B.inverse();
  Eigen::Matrix3d L = Eigen::Matrix3d::Zero(), U = Eigen::Matrix3d::Identity();
  for (int j = 0; j < 3; ++j) {
    for (int i = j; i < 3; ++i) L(i, j) = A(i, j) - L.row(i).head(j).dot(U.col(j).head(j));
    for (int i = j + 1; i < 3; ++i) U(j, i) = (A(j, i) - L.row(j).head(j).dot(U.col(i).head(j))) / L(j, j);
  }
  L_inverse_ = L.inverse();
  for (Eigen::VectorXd* x : {&rate_, &product_, &rhs_}) x->setZero(stages_[0]->form.size());
}

void RadauStages::set_start(const State& s) {
  for (auto& stage : stages_) stage->form.set_start(s);
}

bool RadauStages::linearise(int i, double t, const Eigen::VectorXd& y, const Eigen::VectorXd& yp, double h) {
  Stage& stage = *stages_[static_cast<std::size_t>(i)];
  h_ = h;
  ++linearised_;
  stage.form.linearise(t, y, yp, TangentScope::everything);
  return stage.matrix.factor(L_inverse_(i, i) / h);
}

void RadauStages::solve(std::array<Eigen::VectorXd, 3>& R) {
  for (int i = 0; i < 3; ++i) {
    Stage& stage = *stages_[static_cast<std::size_t>(i)];
    rate_.setZero();
    for (int j = 0; j < i; ++j) rate_ += L_inverse_(i, j) / h_ * R[static_cast<std::size_t>(j)];
    stage.form.multiply_rates(rate_, product_);
    rhs_ = -R[static_cast<std::size_t>(i)] - product_;
    stage.matrix.solve(rhs_, R[static_cast<std::size_t>(i)]);
  }
}

long RadauStages::evaluations() const {
  long sum = 0;
  for (const auto& stage : stages_) sum += stage->form.evaluations();
  return sum;
}

}  // namespace flexura::mbs
