// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/redundancy.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

/// Which constraint rows say nothing new.
namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A row is dependent when what is left of it beside the kept rows is below this part of its length: markers are
/// written with nine digits, angles between the parts of a loop make ten or a hundred times as much of the rest,
/// and what is left out is watched to a millionth (row_watch.hpp).
constexpr double dependent = 1e-6;
/// Modal coordinates count by so much: modes that close a row by a thousandth of what they do elsewhere (a mesh that is not quite
/// symmetric, the twist of a bar that is bent about two axes) hold it a million times as hard as those left out would.
constexpr double by_deformation = 1e-3;
/// A row is nothing at all where no motion as large as the mechanism changes it by more than this part of its
/// size (ConstraintSizes). Axes of a door written with nine digits leave 1e-9, which normalised would pass for a
/// direction that the hinges hold; arms of lengths can be far smaller than the mechanism.
constexpr double vanishing_angle = 1e-6, vanishing_length = 1e-8;

/// Orthogonalises the rows in turn, the longest remainder first (pivoting keeps the choice well conditioned),
/// those `of_positions` before the others, and returns the kept ones in ascending order.
std::vector<int> independent_rows(const MatrixXd& G, const std::vector<bool>& of_positions,
                                  const VectorXd& weights) {
  const int n = static_cast<int>(G.rows());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> Q = G;
  for (int i = 0; i < n; ++i) {
    const double length = Q.row(i).norm();
    if (length > 0.0) Q.row(i) /= length;
  }
  std::vector<int> kept;
  std::vector<bool> done(n, false);
  for (bool first = true;;) {
    int best = -1;
    double longest = dependent;
    for (int i = 0; i < n; ++i) {
      if (done[i] || (first && !of_positions[i])) continue;
      const double length = Q.row(i).cwiseProduct(weights.transpose()).norm();
      // Of rows that are about equally good the first in the file stays.
      if (length > longest * (best < 0 ? 1.0 : 1.5)) best = i, longest = length;
    }
    if (best < 0 && !first) break;
    if (best < 0) {
      first = false;
      continue;
    }
    done[best] = true;
    kept.push_back(best);
    const Eigen::RowVectorXd q = Q.row(best).normalized();
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

Redundancy find_redundancy(const Equations& mechanism, When when, ConstVectorRef p, const VectorXd& scale,
                           const std::vector<bool>& is_modal, const std::vector<bool>& of_positions,
                           const std::vector<bool>& lasts) {
  const auto scratch = mechanism.make_scratch();
  const ConstraintSizes sizes = mechanism.constraint_sizes(when, p, *scratch);
  const int n_rows = static_cast<int>(sizes.is_length.size()), n_v = static_cast<int>(scale.size());
  Redundancy out;
  for (int i = 0; i < n_rows; ++i) out.kept.push_back(i);
  VectorXd weights(n_v);
  for (int i = 0; i < n_v; ++i) weights(i) = is_modal[static_cast<std::size_t>(i)] ? by_deformation : 1.0;
  // Coordinates are weighed by the mechanism's geometry, so that metres, radians and modal coordinates compare;
  // what is dependent is no matter of masses.
  const auto scaled_G = [&](const VectorXd& at) {
    MatrixXd G(n_rows, n_v);
    mechanism.constraint_matrix(when, at, *scratch, G);
    G = (G * scale.asDiagonal()).eval();
    // What axes that are parallel but for round-off leave of a row would pass for a direction once
    // normalised.
    for (int i = 0; i < n_rows; ++i)
      if (G.row(i).cwiseAbs().maxCoeff() <
          (sizes.is_length[i] ? vanishing_length : vanishing_angle) * sizes.size(i))
        G.row(i).setZero();
    return G;
  };

  // The configuration itself and neighbours along its freedoms: the largest rank counts.
  MatrixXd best_G = scaled_G(p);
  std::vector<int> best = independent_rows(best_G, of_positions, weights);
  if (static_cast<int>(best.size()) == n_rows) return out;  // no neighbour can have a larger rank
  const MatrixXd G_p = best_G;
  // A drive does not last: at its next value the others may be independent that are not here.
  std::vector<int> lasting;
  for (int i = 0; i < n_rows; ++i)
    if (lasts[static_cast<std::size_t>(i)]) lasting.push_back(i);
  const auto rows_of = [&](const MatrixXd& all) {
    MatrixXd some(lasting.size(), all.cols());
    for (std::size_t i = 0; i < lasting.size(); ++i) some.row(i) = all.row(lasting[i]);
    return some;
  };
  const auto decompose = [&](const MatrixXd& G) {
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
    // At a dead point, where positions are known to the square root of round-off only, so is G.
    decomposition.setThreshold(dependent);
    decomposition.compute(G * weights.asDiagonal());
    return decomposition;
  };
  std::uint64_t random = 88172645463325252u;  // a fixed xorshift: the same answer in every run
  const auto uniform = [&random] {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    return 2.0 * static_cast<double>(random >> 11) / 9007199254740992.0 - 1.0;
  };
  VectorXd g(n_rows);
  mechanism.position_constraints(when, p, *scratch, g);
  const double open_at_p = g.norm();
  const MatrixXd held_p = rows_of(G_p);
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposed;
  if (!lasting.empty()) decomposed = decompose(held_p);
  // Neighbours are drawn back onto the constraints by Newton's method with least-norm steps; they are reached by rigid motion, for
  // rows of a plane linkage that deformations make independent do not stay so.
  for (int sample = 0; sample < 4; ++sample) {
    VectorXd z(n_v);
    for (int i = 0; i < n_v; ++i)  // 0.01 rad, or a hundredth of the extent
      z(i) = is_modal[static_cast<std::size_t>(i)] ? 0.0 : 0.01 * uniform();
    if (!lasting.empty()) z -= weights.cwiseProduct(decomposed.solve(VectorXd(held_p * z)));
    VectorXd at = p, next(static_cast<int>(p.size()));
    mechanism.retract(at, VectorXd(scale.asDiagonal() * z), next);
    at = next;
    bool closed = lasting.empty();
    for (int k = 0; k < 20 && !closed; ++k) {
      mechanism.position_constraints(when, at, *scratch, g);
      VectorXd open(lasting.size());
      closed = true;
      for (std::size_t i = 0; i < lasting.size(); ++i) {
        open(i) = g(lasting[i]);
        closed = closed && std::abs(open(i)) <= std::max(1e-12 * sizes.size(lasting[i]), 10.0 * open_at_p);
      }
      if (closed) break;
      const VectorXd step = weights.cwiseProduct(decompose(rows_of(scaled_G(at))).solve(VectorXd(-open)));
      mechanism.retract(at, VectorXd(scale.asDiagonal() * step), next);
      at = next;
    }
    if (!closed || !at.allFinite()) continue;
    MatrixXd G = scaled_G(at);
    std::vector<int> kept = independent_rows(G, of_positions, weights);
    if (kept.size() > best.size()) {
      best = std::move(kept);
      best_G = std::move(G);
    }
  }

  return with_kept(best_G, std::move(best));
}

Redundancy with_kept(const MatrixXd& G, std::vector<int> kept) {
  Redundancy out;
  MatrixXd G_kept(kept.size(), G.cols());
  for (std::size_t i = 0; i < kept.size(); ++i) G_kept.row(i) = G.row(kept[i]);
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> combine;
  if (!kept.empty()) combine.compute(G_kept.transpose());
  for (int i = 0; i < static_cast<int>(G.rows()); ++i) {
    if (std::ranges::binary_search(kept, i)) continue;
    std::vector<int> from;
    VectorXd x;
    if (!kept.empty()) x = combine.solve(VectorXd(G.row(i).transpose()));
    for (std::size_t k = 0; k < kept.size(); ++k)
      if (std::abs(x(k)) * G_kept.row(k).norm() > 1e-6 * G.row(i).norm()) from.push_back(kept[k]);
    out.left_out.push_back(i);
    out.follows_from.push_back(std::move(from));
  }
  out.kept = std::move(kept);
  return out;
}

std::vector<int> most_independent(const MatrixXd& G, const std::vector<int>& candidates, int n) {
  if (n > std::min<Eigen::Index>(static_cast<Eigen::Index>(candidates.size()), G.cols())) return {};
  MatrixXd columns(G.cols(), candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) columns.col(i) = G.row(candidates[i]).transpose();
  const Eigen::ColPivHouseholderQR<MatrixXd> qr(columns);
  std::vector<int> kept;
  for (int i = 0; i < n; ++i) kept.push_back(candidates[qr.colsPermutation().indices()(i)]);
  std::ranges::sort(kept);
  return kept;
}

}  // namespace flexura::mbs
