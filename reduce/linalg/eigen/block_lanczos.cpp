// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/block_lanczos.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::linalg {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The M-orthonormal basis V and the projected operator H = V^T M S V of all but the last block.
class Basis {
 public:
  Basis(const EigenProblem& problem, const BlockLanczosSettings& settings, Index capacity)
      : problem_(problem), settings_(settings), V_(nullptr, problem.n, 0) {
    reserve(capacity);
  }

  Index size() const { return size_; }
  auto vectors() const { return V_.leftCols(size_); }
  auto vectors(Index first, Index count) const { return V_.middleCols(first, count); }

  // M times the newest block, for S to be applied to; it is kept for the recurrence below.
  const MatrixXd& multiply_newest_by_M(Index width) {
    M_before_ = std::move(M_newest_);
    problem_.multiply_M(vectors(size_ - width, width), M_newest_);
    return M_newest_;
  }

  // Makes W orthogonal to the basis and to itself and appends it; what is round-off of W's own size is left
  // out. On return W_before = V_old C + V_new R.
  void append(MatrixXd W, MatrixXd& C, MatrixXd& R) {
    const Index old = size_;
    C.setZero(old, W.cols());
    MatrixXd MW;
    problem_.multiply_M(W, MW);
    const auto columns_squared = [&] {
      Eigen::RowVectorXd squares = W.cwiseProduct(MW).colwise().sum();
      if (problem_.sum) problem_.sum(squares.data(), squares.size());
      return squares.cwiseMax(0.0).eval();
    };
    const double scale = std::sqrt(columns_squared().maxCoeff());
    // In exact arithmetic S V_newest meets only the two newest blocks.  They are taken out first, so that
    // what is taken out along the whole basis, which costs two passes over it, is small.
    Index end = old;
    for (const MatrixXd* M_V : {&M_newest_, &M_before_}) {
      const Index width = M_V->cols();
      if (width == 0 || width > end) break;
      end -= width;
      const MatrixXd c = problem_.inner(*M_V, W);
      add_product(-1.0, V_.middleCols(end, width), c, W);
      add_product(-1.0, *M_V, c, MW);
      C.middleRows(end, width) += c;
    }
    // One pass leaves eps times what it took out; twice is enough (W. Kahan).  MW stays that of W before the
    // pass: V^T M W = 0 makes of this an error of second order in W^T M W.
    constexpr double kSmall = 1e-7;
    for (int pass = 0; pass < 3 && old > 0; ++pass) {
      const MatrixXd c = problem_.inner(V_.leftCols(old), MW);
      add_product(-1.0, V_.leftCols(old), c, W);
      C += c;
      if ((c.colwise().squaredNorm().array() <= kSmall * kSmall * columns_squared().array()).all()) break;
      problem_.multiply_M(W, MW);
    }
    R = orthonormalise(std::move(W), std::move(MW), scale);
  }

  void reserve(Index capacity) {
    if (capacity <= V_.cols()) return;
    if (!settings_.storage) own_.conservativeResize(problem_.n, capacity);
    double* data = settings_.storage ? settings_.storage(capacity) : own_.data();
    new (&V_) Eigen::Map<MatrixXd>(data, problem_.n, capacity);
  }

  // Replaces the basis by V Y and the last block.
  void restart(const MatrixXd& Y, Index last_block) {
    const Index first = size_ - last_block;
    const MatrixXd kept = times(V_.leftCols(first), Y);
    const MatrixXd last = V_.middleCols(first, last_block);
    V_.leftCols(Y.cols()) = kept;
    V_.middleCols(Y.cols(), last_block) = last;
    size_ = Y.cols() + last_block;
    M_newest_.resize(0, 0);  // S V_last meets all of the new basis
  }

 private:
  // Appends an orthonormal basis of span(W), W already orthogonal to the basis, MW = M W; returns R, W =
  // V_new R. The Gram matrix tells directions apart down to 1e-7 of the largest; the rest is cleaned and
  // treated anew.
  MatrixXd orthonormalise(MatrixXd W, MatrixXd MW, double scale) {
    MatrixXd R = MatrixXd::Zero(0, W.cols());
    MatrixXd from_input =
        MatrixXd::Identity(W.cols(), W.cols());  // W_now = (rest) in terms of the input's columns
    const Index first = size_;
    while (W.cols() > 0) {
      const DenseEigen gram = symmetric_eigen(0.5 * (problem_.inner(W, MW) + problem_.inner(MW, W)));
      const double largest = gram.values.maxCoeff();
      const double smallest_kept = 1e-13 * scale;  // a few hundred ulps of what W was made from
      if (!(largest > smallest_kept * smallest_kept)) break;
      Index n_small = 0;
      while (gram.values(n_small) < 1e-10 * largest) ++n_small;
      const Index n_large = W.cols() - n_small;
      const MatrixXd U_small = gram.vectors.leftCols(n_small), U_large = gram.vectors.rightCols(n_large);
      const VectorXd root = gram.values.tail(n_large).cwiseSqrt();
      MatrixXd Q = times(W, U_large * root.cwiseInverse().asDiagonal());
      // Normalising small vectors magnifies what is left of the basis in them, and a wide spread of sizes
      // leaves Q orthonormal to ulps times the spread only: clean again, against everything.
      MatrixXd correction = MatrixXd::Identity(n_large, n_large);
      const bool delicate = root(0) < 1e-2 * root(n_large - 1) || root(0) < 1e-4 * scale;
      for (int pass = 0; pass < (delicate ? 2 : 0); ++pass) {
        problem_.multiply_M(Q, MW);
        const MatrixXd c = problem_.inner(V_.leftCols(size_), MW);
        add_product(-1.0, V_.leftCols(size_), c, Q);
        problem_.multiply_M(Q, MW);
        const DenseEigen g = symmetric_eigen(0.5 * (problem_.inner(Q, MW) + problem_.inner(MW, Q)));
        const VectorXd s = g.values.cwiseMax(1e-300).cwiseSqrt();
        Q = times(Q, g.vectors * s.cwiseInverse().asDiagonal() * g.vectors.transpose());
        correction = (g.vectors * s.asDiagonal() * g.vectors.transpose() * correction).eval();
      }
      V_.middleCols(size_, n_large) = Q;
      size_ += n_large;
      MatrixXd grown = MatrixXd::Zero(R.rows() + n_large, R.cols());
      grown.topRows(R.rows()) = R;
      grown.bottomRows(n_large) = correction * root.asDiagonal() * U_large.transpose() * from_input;
      if (n_small > 0) {
        MatrixXd rest = times(W, U_small);
        from_input = (U_small.transpose() * from_input).eval();
        for (int pass = 0; pass < 2; ++pass) {
          problem_.multiply_M(rest, MW);
          const MatrixXd c = problem_.inner(V_.leftCols(size_), MW);
          add_product(-1.0, V_.leftCols(size_), c, rest);
          grown += c.middleRows(first, size_ - first) * from_input;
        }
        W = std::move(rest);
        problem_.multiply_M(W, MW);
      } else {
        W.resize(W.rows(), 0);
      }
      R = std::move(grown);
    }
    return R;
  }

  const EigenProblem& problem_;
  const BlockLanczosSettings& settings_;
  MatrixXd own_;
  Eigen::Map<MatrixXd> V_;
  MatrixXd M_newest_, M_before_;  // M times the newest block and the one before; empty where not known
  Index size_ = 0;
};

// The lowest eigenpairs of the projected problem.
struct Ritz {
  VectorXd omega2;           // ascending
  MatrixXd Y;                // columns for `omega2`, rows of the projected basis
  VectorXd estimate;         // relative residual of S
  double smallest, largest;  // eigenvalues of H
};

Ritz ritz_pairs(const MatrixXd& H, const MatrixXd& R, Index last_block, double shift) {
  const DenseEigen eigen = symmetric_eigen(0.5 * (H + H.transpose()));
  const Index n = H.rows();
  Ritz ritz{VectorXd(n), eigen.vectors.rowwise().reverse(), VectorXd::Zero(n), eigen.values(0),
            eigen.values(n - 1)};
  for (Index k = 0; k < n; ++k) {
    const double theta = eigen.values(n - 1 - k);
    ritz.omega2(k) = theta > 0.0 ? 1.0 / theta - shift : std::numeric_limits<double>::infinity();
    if (R.rows() > 0) ritz.estimate(k) = (R * ritz.Y.col(k).tail(last_block)).norm() / std::abs(theta);
  }
  return ritz;
}

// How many pairs the request asks for, given what is known; -1: not decided yet.
Index wanted(const Ritz& ritz, const EigenRequest& request, double accurate) {
  Index count = request.count;
  if (ritz.omega2.size() <= count) return -1;
  while (count < ritz.omega2.size() && ritz.omega2(count) <= request.omega2_max) ++count;
  while (count > 0 && count < ritz.omega2.size() &&
         ritz.omega2(count) - ritz.omega2(count - 1) < kClusterGap * std::abs(ritz.omega2(count)))
    ++count;
  // The first one that is left out must be known well enough to be left out.
  if (count >= ritz.omega2.size() || !(ritz.estimate(count) < 1e-4)) return -1;
  return count == 0 || ritz.estimate.head(count).maxCoeff() < accurate ? count : -1;
}

}  // namespace

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
  Index capacity = std::min<Index>(problem.n_free + 2 * b, suggested);
  EigenPairs pairs;
  Basis basis(problem, settings, capacity);
  std::mt19937_64 random(20240229 + static_cast<unsigned>(problem.rank));
  std::normal_distribution<double> normal;

  MatrixXd X(problem.n, b), MX, W, C, R;
  for (double& x : X.reshaped()) x = normal(random);
  problem.multiply_M(X, MX);
  problem.solve(MX, W);
  basis.append(std::move(W), C, R);
  pairs.n_solves += static_cast<int>(b);
  ++pairs.n_blocks;

  MatrixXd H(0, 0);
  Index last = basis.size();  // width of the newest block, which S has not been applied to
  double accurate = std::max(1e-2 * request.tolerance, 1e-14);
  int rounds_without_gain = 0;
  Index next_look = target + b, looked_at = 0, known_then = 0;
  for (int step = 0;; ++step) {
    // S on the newest block.
    problem.solve(basis.multiply_newest_by_M(last), W);
    pairs.n_solves += static_cast<int>(last);
    ++pairs.n_blocks;
    const Index old = basis.size();
    basis.append(std::move(W), C, R);
    H.conservativeResize(old, old);
    H.rightCols(last) = C;
    H.bottomRows(last) = C.transpose();
    const Index applied = last;
    last = basis.size() - old;

    const bool exhausted = last == 0;
    if (!exhausted && old < next_look && step > 0 && basis.size() + b <= capacity) continue;
    const Ritz ritz = ritz_pairs(H, R, applied, problem.shift);
    if (settings.none_below && ritz.smallest < -1e-6 * ritz.largest)
      throw std::invalid_argument(
          "block Lanczos: there are eigenvalues below the shift, which it does not look for; put the shift "
          "(target) "
          "below the spectrum");
    Index count = wanted(ritz, request, accurate);
    if (exhausted && count < 0 && basis.size() < problem.n_free) {
      // No more than `b` vectors of a multiple eigenvalue are in the space of powers of S on `b` vectors: it goes on
      // with others beside it.
      if (basis.size() + 2 * b > capacity) basis.reserve(capacity = basis.size() + 4 * b);
      for (double& x : X.reshaped()) x = normal(random);
      problem.multiply_M(X, MX);
      problem.solve(MX, W);
      basis.append(std::move(W), C, R);
      pairs.n_solves += static_cast<int>(b);
      ++pairs.n_blocks;
      last = basis.size() - old;
      if (last > 0) {
        next_look = basis.size();
        continue;
      }
    }
    if (exhausted && count < 0) {
      // The whole space is spanned: everything there is has been found.
      count = std::min<Index>(request.count, ritz.omega2.size());
      while (count < ritz.omega2.size() && ritz.omega2(count) <= request.omega2_max) ++count;
    }
    Index known = 0;  // leading pairs that are accurate already
    while (known < ritz.estimate.size() && ritz.estimate(known) < accurate) ++known;
    {
      // A look at H costs some 100 size^3, a block 8 n size b in orthogonalisation alone: looks are to be a
      // quarter of that.  The pairs known so far tell when the rest will be.
      const double size = static_cast<double>(old), gained = static_cast<double>(known - known_then);
      const double least = std::clamp(48.0 * size * size / n_rows, static_cast<double>(b),
                                      std::max(size / 8.0, static_cast<double>(b)));
      const double needed = gained > 0.0 ? static_cast<double>(target - known) *
                                               (size - static_cast<double>(looked_at)) / gained
                                         : 0.0;
      next_look = old + static_cast<Index>(std::clamp(needed, least, std::max(least, size / 4.0)));
      looked_at = old;
      known_then = known;
    }
    if (settings.look) settings.look(ritz.omega2, ritz.estimate, known, pairs.n_blocks);
    report(progress, kStage, std::min(0.99, static_cast<double>(known) / static_cast<double>(target)));
    if (count >= 0) {
      MatrixXd Y = ritz.Y.leftCols(count);
      pairs.omega2_next =
          count < ritz.omega2.size() ? ritz.omega2(count) : std::numeric_limits<double>::infinity();
      pairs.Phi = times(basis.vectors().leftCols(old), Y);
      if (!exhausted) {
        MatrixXd tail = R * Y.bottomRows(applied);
        for (Index k = 0; k < count; ++k) tail.col(k) *= ritz.omega2(k) + problem.shift;
        add_product(1.0, basis.vectors(old, last), tail, pairs.Phi);
      }
      orthonormalise(problem, pairs.Phi);
      measure_residuals(problem, pairs);
      polish_until_accurate(problem, request.tolerance, pairs);
      if (count == 0 || is_accurate(pairs, request.tolerance)) {
        report(progress, kStage, 1.0);
        return pairs;
      }
      if (exhausted || ++rounds_without_gain > 8)
        throw std::runtime_error(
            fmt::format("block Lanczos: the worst residual of {} modes stays at {:.1e}, above {:.1e}: the "
                        "stiffness matrix is too "
                        "badly conditioned for this accuracy",
                        count, pairs.residual.maxCoeff(), request.tolerance));
      accurate = std::max(0.1 * accurate, 1e-16);
    }
    if (basis.size() + b > capacity) {
      // Thick restart: the best Ritz vectors and the newest block.  A search up to a frequency that has
      // outgrown the room gets more of it.
      const Index keep = std::min<Index>(old, std::max(target, known) + 2 * b);
      if (2 * keep > capacity)
        basis.reserve(capacity = std::min<Index>(problem.n_free, 2 * capacity) + 2 * b);
      const MatrixXd Y = ritz.Y.leftCols(keep);
      basis.restart(Y, last);
      looked_at = known_then = 0;
      H = MatrixXd::Zero(keep, keep);
      for (Index k = 0; k < keep; ++k) H(k, k) = 1.0 / (ritz.omega2(k) + problem.shift);
    }
    if (step > settings.most_blocks)
      throw std::runtime_error(
          fmt::format("block Lanczos: no convergence in {} blocks", settings.most_blocks));
  }
}

}  // namespace flexura::linalg
