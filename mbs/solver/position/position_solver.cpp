// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/position_solver.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace flexura::mbs {

void PositionSolver::linearise(const Eigen::VectorXd& p) {
  eq_.mass_matrix(p, *scratch_, M_);
  eq_.constraint_matrix(when_, p, *scratch_, G_);
  // A rolling disc's row has no position level.
  for (int k = 0; k < n_.n_lambda; ++k)
    if (!eq_.is_holonomic(k)) G_.row(k).setZero();
  column_scale_ = free_;
  for (int i = 0; i < n_.n_v; ++i)
    if (M_(i, i) > 0.0) column_scale_(i) /= std::sqrt(M_(i, i));
  H_ = G_ * column_scale_.asDiagonal();
  // Sizes follow the mechanism on its way together: a guess may lie far from where it will stand.
  sizes_ = eq_.constraint_sizes(when_, p, *scratch_);
  row_scale_ = Eigen::VectorXd::Ones(n_.n_lambda);
  double largest = 0.0;  // of a row by its size
  for (int k = 0; k < n_.n_lambda; ++k) largest = std::max(largest, H_.row(k).norm() / sizes_.size(k));
  for (int k = 0; k < n_.n_lambda; ++k) {
    const double norm = H_.row(k).norm();
    // Rows that vanish at this instant (a dead point) or for good take the scale of the others.
    const double typical = (largest > 0.0 ? largest : 1.0) * sizes_.size(k);
    row_scale_(k) = 1.0 / (measure_ == Measure::gaps ? typical : norm > 1e-8 * typical ? norm : typical);
  }
  H_ = row_scale_.asDiagonal() * H_;
  // What the loop may be open by where its rows depend on each other: 1e-9 of the mechanism's size, and more
  // only where that is below the round-off of its place in the world.
  allowed_ = (1e-9 * sizes_.size).cwiseMax(1e2 * sizes_.round_off);
}

std::string PositionSolver::rows_out_of_reach() const {
  std::string text;
  for (int k = 0; k < n_.n_lambda; ++k) {
    if (std::abs(g_(k)) <= allowed_(k)) continue;
    const double reach = n_.n_v > 0 ? G_.row(k).cwiseAbs().dot(step_scale_) : 0.0;
    if (reach > 1e-8 * sizes_.size(k)) return {};
    text += fmt::format("{}\"{}\" ({:.6g} {})", text.empty() ? "" : ", ", eq_.name_of_constraint(k), g_(k),
                        sizes_.is_length[k] ? "m" : "rad");
  }
  return text;
}

bool PositionSolver::solve(Eigen::VectorXd& p, int max_iterations) {
  if (n_.n_lambda == 0) return true;
  Eigen::VectorXd d(n_.n_v), p_trial(n_.n_p), g_trial(n_.n_lambda), x;
  Eigen::MatrixXd normal;
  double mu = 0.0, reach = std::numeric_limits<double>::infinity();
  eq_.position_constraints(when_, p, *scratch_, g_);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    linearise(p);
    if (n_.n_v == 0 || is_round_off()) break;
    const double now = merit(g_);
    bool accepted = false;
    for (int attempt = 0; attempt < 12 && !accepted; ++attempt) {
      normal = H_ * H_.transpose();
      // 1e-14 keeps dependent but consistent rows solvable: their residual lies in the range.
      normal.diagonal().array() += std::max(mu, 1e-14);
      x = normal.ldlt().solve(-row_scale_.cwiseProduct(g_));
      d = column_scale_.cwiseProduct(H_.transpose() * x);
      if (!d.allFinite()) break;
      // Half a radian (half the mechanism's length) at a time: further away lies another branch.
      const double largest = d.cwiseAbs().cwiseQuotient(step_scale_).maxCoeff();
      // What is open by little is closed by ways of its size, times one over the sines of the mechanism's angles.
      // Rows that depend on each other but for the last digits of the file (a door on two hinges) can be open by
      // less all along a way of the mechanism than where it stands: no reason to go there.
      constexpr double kChase = 1e5;
      if (nearly_closed()) {
        reach = std::min(reach, kChase * (g_.array() / sizes_.size.array()).abs().maxCoeff());
        if (largest > reach) {
          mu = std::max(10.0 * mu, 1e-8);
          continue;
        }
      }
      double alpha = largest > 0.5 ? 0.5 / largest : 1.0;
      for (int halving = 0; halving < 8; ++halving, alpha *= 0.5) {
        eq_.retract(p, alpha * d, p_trial);
        eq_.position_constraints(when_, p_trial, *scratch_, g_trial);
        if (g_trial.allFinite() && merit(g_trial) < now * (1.0 - 1e-4 * alpha)) {
          accepted = true;
          change_ += alpha * largest;
          reach -= alpha * largest;
          break;
        }
      }
      if (!accepted) mu = std::max(10.0 * mu, 1e-8);
    }
    if (!accepted) break;
    ++iterations_;
    mu = mu > 1e-8 ? 0.1 * mu : 0.0;
    p = p_trial;
    g_ = g_trial;
  }
  linearise(p);
  return (g_.cwiseAbs().array() <= allowed_.array()).all();
}

void PositionSolver::approach(Eigen::VectorXd& p, int max_iterations) {
  constexpr double kSmall = 1e-12;
  Eigen::VectorXd p_trial(n_.n_p), g_trial(n_.n_lambda);
  double mu = 1e-2;
  eq_.position_constraints(when_, p, *scratch_, g_);
  for (; iterations_ < max_iterations && mu < 1e8; ++iterations_) {
    linearise(p);
    Eigen::MatrixXd normal = H_.transpose() * H_;
    const double size = std::max(normal.diagonal().maxCoeff(), 1e-300);
    normal.diagonal().array() += mu * size;
    const Eigen::VectorXd d =
        column_scale_.cwiseProduct(normal.ldlt().solve(-H_.transpose() * row_scale_.cwiseProduct(g_)));
    const double largest = d.cwiseAbs().cwiseQuotient(step_scale_).maxCoeff();
    if (!(largest > kSmall)) break;
    eq_.retract(p, (largest > 0.5 ? 0.5 / largest : 1.0) * d, p_trial);
    eq_.position_constraints(when_, p_trial, *scratch_, g_trial);
    const double now = merit(g_), then = merit(g_trial);
    if (!(then < now)) {
      mu *= 4.0;
      continue;
    }
    p = p_trial;
    g_ = g_trial;
    if (then > now * (1.0 - kSmall)) break;
    mu = std::max(0.3 * mu, 1e-9);
  }
  linearise(p);
}

}  // namespace flexura::mbs
