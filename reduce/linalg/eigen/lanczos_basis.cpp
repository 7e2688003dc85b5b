// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/lanczos_basis.hpp"

#include <cmath>
#include <utility>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::linalg {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

LanczosBasis::LanczosBasis(const EigenProblem& problem, VectorStorage storage, Index capacity)
    : problem_(problem), storage_(std::move(storage)), V_(nullptr, problem.n, 0) {
  reserve(capacity);
}

const MatrixXd& LanczosBasis::multiply_newest_by_M(Index width) {
  M_before_ = std::move(M_newest_);
  problem_.multiply_M(vectors(size_ - width, width), M_newest_);
  return M_newest_;
}

void LanczosBasis::append(MatrixXd W, MatrixXd& C, MatrixXd& R) {
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

void LanczosBasis::reserve(Index capacity) {
  if (capacity <= V_.cols()) return;
  if (!storage_) own_.conservativeResize(problem_.n, capacity);
  double* data = storage_ ? storage_(capacity) : own_.data();
  new (&V_) Eigen::Map<MatrixXd>(data, problem_.n, capacity);
}

void LanczosBasis::restart(const MatrixXd& Y, Index last_block) {
  const Index first = size_ - last_block;
  const MatrixXd kept = times(V_.leftCols(first), Y);
  const MatrixXd last = V_.middleCols(first, last_block);
  V_.leftCols(Y.cols()) = kept;
  V_.middleCols(Y.cols(), last_block) = last;
  size_ = Y.cols() + last_block;
  M_newest_.resize(0, 0);  // S V_last meets all of the new basis
}

// Appends an orthonormal basis of span(W), W already orthogonal to the basis, MW = M W; returns R, W =
// V_new R. The Gram matrix tells directions apart down to 1e-7 of the largest; the rest is cleaned and
// treated anew.
MatrixXd LanczosBasis::orthonormalise(MatrixXd W, MatrixXd MW, double scale) {
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

}  // namespace flexura::linalg
