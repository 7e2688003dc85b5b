// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/invariants/inertia_integrals.hpp"

#include <algorithm>

#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

InertiaIntegrals inertia_integrals(const linalg::SymmetricMatrix& m,
                                   const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>& points,
                                   const Eigen::MatrixXd& T) {
  const Eigen::Index n_nodes = points.rows(), n = T.cols();
  Eigen::MatrixXd X(n_nodes, 4), mX;  // 1, x, y, z
  X.col(0).setOnes();
  X.rightCols<3>() = points;
  m.multiply(X, mX);
  const Eigen::Matrix4d XmX = X.transpose() * mX;
  InertiaIntegrals s;
  s.mass = XmX(0, 0);
  s.S_x = XmX.block<3, 1>(1, 0);
  s.S_xx = 0.5 * (XmX.bottomRightCorner<3, 3>() + XmX.bottomRightCorner<3, 3>().transpose());
  s.S_phi.resize(3, n);
  s.S_xphi.resize(9, n);

  // The rows of T for one direction, contiguous, of some columns at a time: thousands of shapes are most of the memory.
  constexpr Eigen::Index kColumns = 256;
  const auto direction = [&](int a, Eigen::Index first, Eigen::Index count) {
    Eigen::MatrixXd Phi(n_nodes, count);
    for (Eigen::Index k = 0; k < count; ++k)
      for (Eigen::Index node = 0; node < n_nodes; ++node) Phi(node, k) = T(3 * node + a, first + k);
    return Phi;
  };
  constexpr int kPlace[3][3] = {{0, 3, -1}, {-1, 1, 4}, {5, -1, 2}};  // (a, b) -> place in S_phiphi
  for (int b = 0; b < 3; ++b) {
    Eigen::MatrixXd mPhi;
    m.multiply(direction(b, 0, n), mPhi);
    const Eigen::MatrixXd moments = linalg::transpose_times(X, mPhi);  // 4 x n
    s.S_phi.row(b) = moments.row(0);
    for (int a = 0; a < 3; ++a) {
      s.S_xphi.row(3 * a + b) = moments.row(1 + a);
      if (kPlace[a][b] < 0) continue;
      Eigen::MatrixXd& block = s.S_phiphi[kPlace[a][b]];
      block.resize(n, n);
      for (Eigen::Index first = 0; first < n; first += kColumns) {
        const Eigen::Index count = std::min(kColumns, n - first);
        // Of a symmetric one the rest is its mirror image.
        const Eigen::Index from = a == b ? first : 0;
        block.block(first, from, count, n - from) =
            linalg::transpose_times(direction(a, first, count), mPhi.rightCols(n - from));
        if (a != b) continue;
        Eigen::MatrixXd own = block.block(first, first, count, count);
        block.block(first, first, count, count) = 0.5 * (own + own.transpose());
        const Eigen::Index rest = n - first - count;
        block.block(first + count, first, rest, count) =
            block.block(first, first + count, count, rest).transpose();
      }
    }
  }
  return s;
}

}  // namespace flexura::reduce
