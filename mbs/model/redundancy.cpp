// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/model/work.hpp"

/// Which constraint rows say nothing new.
namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A row is dependent when what is left of it beside the kept rows is below this part of its length. Assembly
/// leaves angles wrong by 1e-10 or so, and a true degree of restraint of 1e-7 could not be told from that.
constexpr double dependent = 1e-7;
/// A row is nothing at all below this part of the largest entry of G: far above round-off, and far below the
/// ratio of lengths to angles in a mechanism some micrometres large.
constexpr double vanishing = 1e-9;

/// Orthogonalises the rows in turn, the longest remainder first (pivoting keeps the choice well conditioned),
/// and returns the kept ones in ascending order.
std::vector<int> independent_rows(const MatrixXd& G) {
  const int n = static_cast<int>(G.rows());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> Q = G;
  for (int i = 0; i < n; ++i) {
    const double length = Q.row(i).norm();
    if (length > 0.0) Q.row(i) /= length;
  }
  std::vector<int> kept;
  std::vector<bool> done(n, false);
  while (true) {
    int best = -1;
    double longest = dependent;
    for (int i = 0; i < n; ++i) {
      if (done[i]) continue;
      const double length = Q.row(i).norm();
      // Of rows that are about equally good the first in the file stays.
      if (length > longest * (best < 0 ? 1.0 : 1.5)) best = i, longest = length;
    }
    if (best < 0) break;
    done[best] = true;
    kept.push_back(best);
    const Eigen::RowVectorXd q = Q.row(best) / longest;
    for (int i = 0; i < n; ++i) {
      if (done[i]) continue;
      for (int pass = 0; pass < 2; ++pass) {
        const double along = Q.row(i).dot(q);
        if (along == 0.0) break;  // joints far from each other
        Q.row(i) -= along * q;
      }
    }
  }
  std::ranges::sort(kept);
  return kept;
}

}  // namespace

std::vector<RedundantRow> Mechanism::drop_redundant(double t, ConstVectorRef p) {
  kept_rows_.resize(first_row_.back());
  for (std::size_t i = 0; i < kept_rows_.size(); ++i) kept_rows_[i] = static_cast<int>(i);
  const int n_rows = first_row_.back();
  if (n_rows == 0) return {};

  const auto scratch = make_scratch();
  // Speeds are weighed by what they carry, so that metres, radians and modal coordinates compare.
  MatrixXd M(n_v_, n_v_);
  mass_matrix(p, *scratch, M);
  VectorXd scale(n_v_);
  const double floor = 1e-12 * M.diagonal().cwiseAbs().maxCoeff();
  for (int i = 0; i < n_v_; ++i) scale(i) = 1.0 / std::sqrt(std::max(M(i, i), std::max(floor, 1e-300)));

  const auto scaled_G = [&](const VectorXd& at) {
    MatrixXd G(n_rows, n_v_);
    constraint_matrix(t, at, *scratch, G);
    // What axes that are parallel but for round-off leave of a row would pass for a direction once
    // normalised.
    const double nothing = vanishing * G.cwiseAbs().maxCoeff();
    for (int i = 0; i < n_rows; ++i)
      if (G.row(i).cwiseAbs().maxCoeff() < nothing) G.row(i).setZero();
    return MatrixXd(G * scale.asDiagonal());
  };

  // The configuration itself and neighbours along its freedoms: the largest rank counts.  Neighbours are
  // drawn back onto the constraints by Newton's method with least-norm steps.
  MatrixXd best_G = scaled_G(p);
  std::vector<int> best = independent_rows(best_G);
  std::uint64_t random = 88172645463325252u;  // a fixed xorshift: the same answer in every run
  const auto uniform = [&random] {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    return 2.0 * static_cast<double>(random >> 11) / 9007199254740992.0 - 1.0;
  };
  if (static_cast<int>(best.size()) == n_rows) return {};  // no neighbour can have a larger rank
  VectorXd g(n_rows);
  position_constraints(t, p, *scratch, g);
  const double residual_0 = g.norm();
  const MatrixXd G_p = best_G;
  const Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposed(G_p);
  for (int sample = 0; sample < 4; ++sample) {
    VectorXd z(n_v_);
    for (int i = 0; i < n_v_; ++i) z(i) = 0.01 * velocity_scale(i) * uniform() / scale(i);
    const VectorXd free = z - decomposed.solve(VectorXd(G_p * z));  // 0.01 rad or 0.01 m
    VectorXd at = p, next(n_p_);
    retract(at, VectorXd(scale.asDiagonal() * free), next);
    at = next;
    bool closed = false;
    for (int k = 0; k < 12 && !closed; ++k) {
      position_constraints(t, at, *scratch, g);
      closed = g.norm() <= std::max(1e-12, 10.0 * residual_0);
      if (closed) break;
      const VectorXd step = Eigen::CompleteOrthogonalDecomposition<MatrixXd>(scaled_G(at)).solve(-g);
      retract(at, VectorXd(scale.asDiagonal() * step), next);
      at = next;
    }
    if (!closed) continue;
    MatrixXd G = scaled_G(at);
    std::vector<int> kept = independent_rows(G);
    if (kept.size() > best.size()) {
      best = std::move(kept);
      best_G = std::move(G);
    }
  }

  // What the rows left out follow from.
  std::vector<RedundantRow> redundant;
  MatrixXd G_kept(best.size(), n_v_);
  for (std::size_t i = 0; i < best.size(); ++i) G_kept.row(i) = best_G.row(best[i]);
  std::vector<std::string> names(n_rows);
  for (int i = 0; i < n_rows; ++i) names[i] = name_of_constraint(i);
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> combine;
  if (!best.empty()) combine.compute(G_kept.transpose());
  for (int i = 0; i < n_rows; ++i) {
    if (std::ranges::binary_search(best, i)) continue;
    RedundantRow row{names[i], {}};
    VectorXd x;
    if (!best.empty()) x = combine.solve(best_G.row(i).transpose());
    for (std::size_t k = 0; k < best.size(); ++k)
      if (std::abs(x(k)) * G_kept.row(k).norm() > 1e-6 * best_G.row(i).norm())
        row.follows_from.push_back(names[best[k]]);
    redundant.push_back(std::move(row));
  }
  kept_rows_ = std::move(best);
  return redundant;
}

}  // namespace flexura::mbs
