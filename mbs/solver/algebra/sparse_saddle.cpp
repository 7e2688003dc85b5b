// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/sparse_saddle.hpp"

#include <Eigen/SparseCholesky>
#include <cmath>

namespace flexura::mbs {

namespace {

// Where the dense factors take longer: 100 bodies in a chain are at 2600 coordinates.
constexpr int kSparseFrom = 300;
constexpr double kSparseBelow = 0.1;  // of all entries of M
// Pivots of M and S below this are left to the dense way.  S has the square of G's condition: from pivots of
// 1e-6 one refinement leads to round-off (1e-16 / 1e-6 of an error of 1e-10).
constexpr double kSmallestPivot = 1e-6;

}  // namespace

struct SparseSaddle::Impl {
  using Sparse = Eigen::SparseMatrix<double>;
  Sparse M, G_T, X;  // X = M^-1 G^T
  Eigen::SimplicialLDLT<Sparse> of_M, of_S;
  Eigen::VectorXd f, h, x, y;

  static bool is_safe(const Eigen::SimplicialLDLT<Sparse>& factors) {
    return factors.info() == Eigen::Success && factors.vectorD().minCoeff() > kSmallestPivot;
  }
  void solve_once() {
    x = of_M.solve(f);
    y = G_T.transpose() * x - h;
    y = of_S.solve(y).eval();
    x -= X * y;
  }
};

SparseSaddle::SparseSaddle() : impl_(std::make_unique<Impl>()) {}
SparseSaddle::~SparseSaddle() = default;

bool SparseSaddle::factor(const Eigen::MatrixXd& M, const Eigen::MatrixXd& G_T) {
  Impl& s = *impl_;
  const double n = static_cast<double>(M.rows());
  if (n < kSparseFrom || G_T.cols() == 0) return false;
  if (static_cast<double>((M.array() != 0.0).count()) > kSparseBelow * n * n) return false;
  s.M = M.sparseView();
  s.G_T = G_T.sparseView();
  s.of_M.compute(s.M);
  if (!Impl::is_safe(s.of_M)) return false;
  s.X = s.of_M.solve(s.G_T);
  s.of_S.compute(Impl::Sparse(s.G_T.transpose() * s.X));
  return Impl::is_safe(s.of_S);
}

// Pivots of S are squares of those of B.
double SparseSaddle::independence() const {
  const auto& D = impl_->of_S.vectorD();
  return std::sqrt(D.minCoeff() / D.maxCoeff());
}

void SparseSaddle::solve(const Eigen::VectorXd& f, const Eigen::VectorXd& h, Eigen::VectorXd& x,
                         Eigen::VectorXd& y) {
  Impl& s = *impl_;
  s.f = f;
  s.h = h;
  s.solve_once();
  x = s.x;
  y = s.y;
  s.f -= s.M * x;
  s.f -= s.G_T * y;
  s.h -= s.G_T.transpose() * x;
  s.solve_once();
  x += s.x;
  y += s.y;
}

}  // namespace flexura::mbs
