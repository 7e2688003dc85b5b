// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/saddle.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/algebra/sparse_saddle.hpp"

namespace flexura::mbs {

struct SaddleSolver::Impl {
  int n_v = 0, n_lambda = 0;
  std::vector<int> free;  // the entries of x that take part
  Eigen::MatrixXd M_hat, B;
  Eigen::VectorXd column_scale, row_scale, f, y_hat, h_hat, w;
  SparseSaddle sparse;
  bool is_sparse = false;  // of the last factor()
  Eigen::LLT<Eigen::MatrixXd> cholesky;
  // B P = Q R where the rows of G are independent; only where they are not, the complete decomposition.
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> complete;
  bool full_rank() const { return qr.rank() == n_lambda; }

  // x <- Q x or Q^T x by the reflections I - tau v v^T, v = (1, essential part); Eigen's own way allocates.
  void reflect(int k, Eigen::VectorXd& x) const {
    const auto below = x.size() - k - 1;
    const auto essential = qr.matrixQR().col(k).tail(below);
    const double along = qr.hCoeffs()(k) * (x(k) + essential.dot(x.tail(below)));
    x(k) -= along;
    x.tail(below) -= along * essential;
  }
  void apply_Q(Eigen::VectorXd& x) const {
    for (int k = n_lambda - 1; k >= 0; --k) reflect(k, x);
  }
  void apply_QT(Eigen::VectorXd& x) const {
    for (int k = 0; k < n_lambda; ++k) reflect(k, x);
  }
  // y <- B^+ x; x is used up.
  void solve_least_squares(Eigen::VectorXd& x, Eigen::VectorXd& y) {
    if (!full_rank()) {
      y = complete.solve(x);
      return;
    }
    apply_QT(x);
    auto top = x.head(n_lambda);
    qr.matrixR().topLeftCorner(n_lambda, n_lambda).triangularView<Eigen::Upper>().solveInPlace(top);
    y.noalias() = qr.colsPermutation() * top;
  }
  // x <- B^+T y
  void solve_transposed(const Eigen::VectorXd& y, Eigen::VectorXd& x) {
    if (!full_rank()) {
      x = complete.transpose().solve(y);
      return;
    }
    x.setZero(B.rows());
    auto top = x.head(n_lambda);
    top.noalias() = qr.colsPermutation().transpose() * y;
    qr.matrixR()
        .topLeftCorner(n_lambda, n_lambda)
        .triangularView<Eigen::Upper>()
        .transpose()
        .solveInPlace(top);
    apply_Q(x);
  }
};

SaddleSolver::SaddleSolver() : impl_(std::make_unique<Impl>()) {}
SaddleSolver::~SaddleSolver() = default;

int SaddleSolver::rank() const {
  if (impl_->n_lambda == 0 || impl_->free.empty()) return 0;
  return impl_->is_sparse ? impl_->n_lambda : static_cast<int>(impl_->qr.rank());
}
double SaddleSolver::independence() const {
  const Impl& s = *impl_;
  if (s.n_lambda == 0) return 1.0;
  if (static_cast<int>(s.free.size()) < s.n_lambda) return 0.0;
  if (s.is_sparse) return s.sparse.independence();
  const double largest = std::abs(s.qr.matrixR()(0, 0));
  return largest > 0.0 ? std::abs(s.qr.matrixR()(s.n_lambda - 1, s.n_lambda - 1)) / largest : 0.0;
}
const Eigen::VectorXd& SaddleSolver::row_scale() const {
  return impl_->row_scale;
}
const Eigen::VectorXd& SaddleSolver::column_scale() const {
  return impl_->column_scale;
}

namespace {

[[noreturn]] void refuse_mass(const Equations& eq, int i, double M_ii) {
  throw std::runtime_error(fmt::format(
      "the mass matrix is not positive definite at \"{}\" (diagonal entry {:.3g}): give the bodies that this "
      "coordinate moves a positive mass or inertia of their own",
      eq.name_of_velocity(i), M_ii));
}

// Index of the first pivot of a matrix with unit diagonal that is round-off (the coordinate's inertia is all
// shared with the ones before it), or -1.  `factor` is its Cholesky factor if there is one.
int first_small_pivot(const Eigen::MatrixXd& A, const Eigen::MatrixXd* factor) {
  const int n = static_cast<int>(A.rows());
  const double floor = 4.0 * std::max(n, 1) * std::numeric_limits<double>::epsilon();
  if (factor != nullptr) {
    for (int i = 0; i < n; ++i)
      if ((*factor)(i, i) * (*factor)(i, i) < floor) return i;
    return -1;
  }
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(n, n);
  for (int j = 0; j < n; ++j) {
    const double pivot = A(j, j) - L.row(j).head(j).squaredNorm();
    if (!(pivot >= floor)) return j;
    L(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < n; ++i) L(i, j) = (A(i, j) - L.row(i).head(j).dot(L.row(j).head(j))) / L(j, j);
  }
  return n - 1;
}

}  // namespace

void SaddleSolver::factor(const Equations& eq, const Eigen::MatrixXd& M, const Eigen::MatrixXd& G,
                          const std::vector<bool>& is_free) {
  Impl& s = *impl_;
  s.n_v = static_cast<int>(M.rows());
  s.n_lambda = static_cast<int>(G.rows());
  s.free.clear();
  for (int i = 0; i < s.n_v; ++i)
    if (is_free.empty() || is_free[i]) s.free.push_back(i);
  const int n = static_cast<int>(s.free.size());

  s.column_scale.resize(s.n_v);
  for (int i = 0; i < s.n_v; ++i) {
    if (!(M(i, i) > 0.0)) refuse_mass(eq, i, M(i, i));
    s.column_scale(i) = 1.0 / std::sqrt(M(i, i));
  }
  s.M_hat.resize(n, n);
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      s.M_hat(i, j) = s.column_scale(s.free[i]) * M(s.free[i], s.free[j]) * s.column_scale(s.free[j]);
  s.row_scale = Eigen::VectorXd::Zero(s.n_lambda);
  s.B.resize(n, s.n_lambda);
  for (int k = 0; k < s.n_lambda; ++k) {
    for (int i = 0; i < n; ++i) s.B(i, k) = G(k, s.free[i]) * s.column_scale(s.free[i]);
    // Its own length, in all entries: of a row that the free ones do not move they hold round-off alone.
    const double norm = G.row(k).transpose().cwiseProduct(s.column_scale).norm();
    if (norm > 0.0) s.row_scale(k) = 1.0 / norm;
    s.B.col(k) *= s.row_scale(k);
  }
  // Rows have unit length; a pivot of 1e-10 means two constraints whose directions differ by 1e-10, or a row that what
  // is free does not move: nothing but geometry errors of the input would be amplified by resolving it.
  constexpr double kRoundOff = 1e-10;
  const bool none_is_held = s.n_lambda == 0 || s.B.colwise().norm().minCoeff() > kRoundOff;
  s.is_sparse = none_is_held && s.sparse.factor(s.M_hat, s.B);
  if (s.is_sparse) return;
  s.cholesky.compute(s.M_hat);
  if (const int i =
          first_small_pivot(s.M_hat, s.cholesky.info() == Eigen::Success ? &s.cholesky.matrixLLT() : nullptr);
      i >= 0)
    refuse_mass(eq, s.free[i], M(s.free[i], s.free[i]));
  if (s.n_lambda == 0 || n == 0) return;
  s.cholesky.matrixL().solveInPlace(s.B);
  s.qr.compute(s.B);
  // Eigen's is relative to the largest pivot, which may be round-off itself.
  s.qr.setThreshold(s.qr.maxPivot() > 0.0 ? kRoundOff / std::min(1.0, s.qr.maxPivot()) : kRoundOff);
  if (s.full_rank()) return;
  s.complete.setThreshold(s.qr.threshold());
  s.complete.compute(s.B);
}

void SaddleSolver::solve(const Eigen::VectorXd& r, const Eigen::VectorXd& h, Eigen::VectorXd& x,
                         Eigen::VectorXd& y) {
  Impl& s = *impl_;
  const int n = static_cast<int>(s.free.size());
  if (n == 0) {
    x = Eigen::VectorXd::Zero(s.n_v);
    y = Eigen::VectorXd::Zero(s.n_lambda);
    return;
  }
  s.f.resize(n);
  for (int i = 0; i < n; ++i) s.f(i) = s.column_scale(s.free[i]) * r(s.free[i]);
  const auto take_out = [&] {
    x = Eigen::VectorXd::Zero(s.n_v);
    for (int i = 0; i < n; ++i) x(s.free[i]) = s.column_scale(s.free[i]) * s.w(i);
  };
  if (s.is_sparse) {
    s.h_hat = s.row_scale.cwiseProduct(h);
    s.sparse.solve(s.f, s.h_hat, s.w, s.y_hat);
    y = s.row_scale.cwiseProduct(s.y_hat);
    take_out();
    return;
  }
  s.cholesky.matrixL().solveInPlace(s.f);
  // In w = L^T x: w + B y = f, B^T w = h.  So w = (I - B B^+) f + B^+T h and y = B^+ (f - w).
  if (s.n_lambda > 0) {
    s.y_hat = s.row_scale.cwiseProduct(h);
    s.solve_transposed(s.y_hat, s.w);
    s.h_hat = s.f;
    s.solve_least_squares(s.h_hat, s.y_hat);
    s.w += s.f;
    s.w.noalias() -= s.B * s.y_hat;
    s.h_hat = s.f - s.w;
    s.solve_least_squares(s.h_hat, s.y_hat);
    y = s.row_scale.cwiseProduct(s.y_hat);
  } else {
    s.w = s.f;
    y.resize(0);
  }
  s.cholesky.matrixU().solveInPlace(s.w);
  take_out();
}

}  // namespace flexura::mbs
