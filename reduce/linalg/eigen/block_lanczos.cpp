// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/block_lanczos.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "reduce/linalg/eigen/lanczos_space.hpp"

namespace flexura::linalg {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// omega^2 of theta, ascending as theta descends; infinite where there is none above the shift.
VectorXd squares(const VectorXd& theta, double shift) {
  return (theta.array() > 0.0)
      .select(theta.array().inverse() - shift,
              Eigen::ArrayXd::Constant(theta.size(), std::numeric_limits<double>::infinity()));
}

// How many pairs the request asks for, given what is known; -1: not decided yet.
Index wanted(const VectorXd& omega2, const VectorXd& estimate, const EigenRequest& request, double accurate) {
  Index count = request.count;
  if (omega2.size() <= count) return -1;
  while (count < omega2.size() && omega2(count) <= request.omega2_max) ++count;
  while (count > 0 && count < omega2.size() &&
         omega2(count) - omega2(count - 1) < kClusterGap * std::abs(omega2(count)))
    ++count;
  // The first one that is left out must be known well enough to be left out.
  if (count >= omega2.size() || !(estimate(count) < 1e-4)) return -1;
  return count == 0 || estimate.head(count).maxCoeff() < accurate ? count : -1;
}

}  // namespace

Index largest_cluster(const Eigen::Ref<const VectorXd>& omega2, double gap) {
  Index largest = 0, first = 0;
  for (Index k = 0; k < omega2.size(); ++k) {
    if (k > 0 && omega2(k) - omega2(k - 1) >= gap * std::abs(omega2(k))) first = k;
    largest = std::max(largest, k - first + 1);
  }
  return largest;
}

int block_lanczos_width(int count) {
  constexpr int kNarrow = 8, kWide = 16, kMany = 200;
  return count < kMany ? kNarrow : kWide;
}

// Room for a Krylov space without a restart in the usual case; a search up to a frequency may need to grow.
int block_lanczos_vectors(int count, int block, double room) {
  count = std::max(count, 1);
  const int most = 4 * count + 17 * block, least = std::min(most, count + count / 3 + 4 * block);
  return static_cast<int>(std::clamp(room, static_cast<double>(least), static_cast<double>(most)));
}

EigenPairs iterate_block_lanczos(const EigenProblem& problem, const EigenRequest& request,
                                 const BlockLanczosSettings& settings, const Progress& progress) {
  constexpr const char* kStage = "modes (block Lanczos)";
  const int block = std::max(1, settings.block);
  double n_rows = problem.n;  // of all processes
  if (problem.sum) problem.sum(&n_rows, 1);
  const Index b = std::min<Index>(block, problem.n_free);
  const Index target = std::max(request.count, 1);
  // Restarts keep the pairs wanted and two blocks, and need some room beside them.
  const Index suggested = settings.most_vectors > 0 ? std::max<Index>(settings.most_vectors, target + 5 * b)
                                                    : block_lanczos_vectors(request.count, block);
  LanczosSpace space(problem, settings.storage, b, std::min<Index>(problem.n_free + 2 * b, suggested));
  // The residual that is measured with K and M in the end was half of that of S, or round-off, on five solid parts of `cases`.
  double accurate = std::max(0.1 * request.tolerance, 1e-14);
  int rounds_without_gain = 0, settled = 0;  // blocks before which nothing is taken for found
  LanczosLooks looks(n_rows, b, target + b);
  for (int step = 0;; ++step) {
    space.expand();
    const Index size = space.size();
    if (!space.exhausted() && !looks.due(size) && step > 0 && !space.is_full()) continue;
    const LanczosSpace::RitzPairs ritz = space.ritz_pairs();
    const VectorXd omega2 = squares(ritz.theta, problem.shift);
    if (settings.none_below && ritz.theta(size - 1) < -1e-6 * ritz.theta(0))
      throw std::invalid_argument(
          "block Lanczos: there are eigenvalues below the shift, which it does not look for; put the shift "
          "(target) "
          "below the spectrum");
    Index count = wanted(omega2, ritz.estimate, request, accurate);
    const bool everything = space.exhausted();
    // A cluster of as many members as vectors that the space has come from may have more, as equal bays between stiff bulkheads
    // have.  With what is found out of their way others need no more blocks than that took, as a rule half of them.
    const bool crowded = count > 0 && largest_cluster(omega2.head(count), kClusterGap) >= space.n_starting();
    if (((everything && count < 0) || crowded) && space.begin_anew(crowded ? space.n_starting() : b)) {
      if (crowded) settled = space.n_blocks() + std::max(4, space.n_blocks() / 2);
      looks.set_next(space.size_with_newest());
      continue;
    }
    if (!everything && space.n_blocks() < settled) count = -1;
    if (everything && count < 0) {
      // The whole space is spanned: everything there is has been found.
      count = std::min<Index>(request.count, omega2.size());
      while (count < omega2.size() && omega2(count) <= request.omega2_max) ++count;
    }
    Index known = 0;  // leading pairs that are accurate already
    while (known < ritz.estimate.size() && ritz.estimate(known) < accurate) ++known;
    const double worst =
        size < target ? 1.0 : ritz.estimate.head(target).maxCoeff();  // of the pairs that are wanted
    looks.plan(size, known, target, worst / accurate);
    if (settings.look) settings.look(omega2, ritz.estimate, known, space.n_blocks());
    report(progress, kStage, std::min(0.99, static_cast<double>(known) / static_cast<double>(target)));
    if (count >= 0) {
      EigenPairs pairs;
      pairs.n_solves = space.n_solves();
      pairs.n_blocks = space.n_blocks();
      pairs.omega2_next = count < omega2.size() ? omega2(count) : std::numeric_limits<double>::infinity();
      pairs.Phi = space.vectors(ritz.Y.leftCols(count), ritz.theta.head(count));
      orthonormalise(problem, pairs.Phi);
      measure_residuals(problem, pairs);
      polish_until_accurate(problem, request.tolerance, pairs);
      if (count == 0 || is_accurate(pairs, request.tolerance)) {
        report(progress, kStage, 1.0);
        return pairs;
      }
      if (everything || ++rounds_without_gain > 8)
        throw std::runtime_error(
            fmt::format("block Lanczos: the worst residual of {} modes stays at {:.1e}, above {:.1e}: the "
                        "stiffness matrix is too "
                        "badly conditioned for this accuracy",
                        count, pairs.residual.maxCoeff(), request.tolerance));
      accurate = std::max(0.1 * accurate, 1e-16);
    }
    if (space.is_full()) {
      // Thick restart: the best Ritz vectors and the newest block.  A search up to a frequency that has
      // outgrown the room gets more of it.
      // Of a cluster all: they take turns in being accurate.
      Index whole = std::min(size, std::max(target, known));
      while (whole < size && omega2(whole) - omega2(whole - 1) < kClusterGap * std::abs(omega2(whole)))
        ++whole;
      const Index keep = std::min<Index>(size, whole + 2 * b);
      if (2 * keep > space.capacity())
        space.reserve(std::min<Index>(problem.n_free, 2 * space.capacity()) + 2 * b);
      space.restart(ritz.Y.leftCols(keep), ritz.theta.head(keep));
      looks.forget();
    }
    if (step > settings.most_blocks)
      throw std::runtime_error(
          fmt::format("block Lanczos: no convergence in {} blocks", settings.most_blocks));
  }
}

}  // namespace flexura::linalg
