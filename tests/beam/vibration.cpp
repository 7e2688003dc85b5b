// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/beam/vibration.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <stdexcept>

namespace flexura::beam::testing {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

std::vector<int> numbering(int n, const std::vector<int>& fixed, int& free) {
  std::vector<int> index(n, 0);
  for (const int dof : fixed) index[dof] = -1;
  free = 0;
  for (int& i : index)
    if (i == 0) i = free++;
  return index;
}

Sparse restrict(const Sparse& A, const std::vector<int>& index, int free) {
  std::vector<Eigen::Triplet<double>> triplets;
  for (int column = 0; column < A.outerSize(); ++column)
    for (Sparse::InnerIterator it(A, column); it; ++it)
      if (index[it.row()] >= 0 && index[column] >= 0)
        triplets.emplace_back(index[it.row()], index[column], it.value());
  Sparse B(free, free);
  B.setFromTriplets(triplets.begin(), triplets.end());
  return B;
}

}  // namespace

Modes lowest_modes(const Sparse& K_all, const Sparse& M_all, const std::vector<int>& fixed, int count,
                   double shift) {
  int n = 0;
  const std::vector<int> index = numbering(static_cast<int>(K_all.rows()), fixed, n);
  const Sparse K = restrict(K_all, index, n), M = restrict(M_all, index, n);
  const Sparse shifted = K + shift * M;
  const Eigen::SimplicialLDLT<Sparse> factor(shifted);
  if (factor.info() != Eigen::Success) throw std::runtime_error("K + shift M is singular");
  const int p = std::min(n, 2 * count + 8);
  Eigen::MatrixXd X(n, p);
  for (int j = 0; j < p; ++j)
    for (int i = 0; i < n; ++i) X(i, j) = std::sin(1.0 + 0.7 * i + 2.3 * j + 0.01 * i * j);
  Eigen::VectorXd values;
  for (int iteration = 0; iteration < 60; ++iteration) {
    const Eigen::MatrixXd Y = M * X, Z = factor.solve(Y);
    // Ritz on the inverse operator: (Z^T Y) y = mu (Z^T M Z) y keeps the low end's digits.
    const Eigen::MatrixXd MZ = M * Z;
    Eigen::MatrixXd A = Z.transpose() * MZ;
    const Eigen::VectorXd scale = A.diagonal().cwiseSqrt().cwiseInverse();
    Eigen::MatrixXd unit = scale.asDiagonal() * A * scale.asDiagonal();
    // M-orthonormalise through the eigenvectors of the scaled Gram matrix, dropping directions already
    // spanned.
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> gram(unit);
    const int rank = static_cast<int>((gram.eigenvalues().array() > 1e-13).count());
    const Eigen::MatrixXd basis = Z * (scale.asDiagonal() * gram.eigenvectors().rightCols(rank) *
                                       gram.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal());
    const Eigen::MatrixXd B = M * basis, inverse = B.transpose() * factor.solve(B);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> ritz(0.5 * (inverse + inverse.transpose()));
    const Eigen::VectorXd mu = ritz.eigenvalues().reverse();
    X = basis * ritz.eigenvectors().rowwise().reverse();
    const Eigen::VectorXd old = values;
    values = mu.head(std::min(count, rank)).cwiseInverse().array() - shift;
    if (old.size() == values.size() &&
        (old - values).cwiseAbs().maxCoeff() < 1e-15 * (values.cwiseAbs().maxCoeff() + shift))
      break;
  }
  Modes modes;
  modes.omega2 = values;
  modes.shapes = Eigen::MatrixXd::Zero(K_all.rows(), values.size());
  for (std::size_t i = 0; i < index.size(); ++i)
    if (index[i] >= 0) modes.shapes.row(i) = X.row(index[i]).head(values.size());
  return modes;
}

Eigen::VectorXd static_solution(const Sparse& K_all, const Eigen::VectorXd& load,
                                const std::vector<int>& fixed) {
  int n = 0;
  const std::vector<int> index = numbering(static_cast<int>(K_all.rows()), fixed, n);
  const Eigen::SimplicialLDLT<Sparse> factor(restrict(K_all, index, n));
  if (factor.info() != Eigen::Success) throw std::runtime_error("K is singular");
  Eigen::VectorXd p(n);
  for (std::size_t i = 0; i < index.size(); ++i)
    if (index[i] >= 0) p(index[i]) = load(i);
  const Eigen::VectorXd solution = factor.solve(p);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(load.size());
  for (std::size_t i = 0; i < index.size(); ++i)
    if (index[i] >= 0) u(i) = solution(index[i]);
  return u;
}

}  // namespace flexura::beam::testing
