// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// Tall dense products on the machine's BLAS (all cores), and small dense eigenproblems, behind one .cpp.
namespace flexura::linalg {

/// A^T B for tall A (n x p), B (n x q).
Eigen::MatrixXd transpose_times(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                const Eigen::Ref<const Eigen::MatrixXd>& B);

/// C += alpha A B for tall A (n x p), small B (p x q).
void add_product(double alpha, const Eigen::Ref<const Eigen::MatrixXd>& A,
                 const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> C);

/// A B.
Eigen::MatrixXd times(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::Ref<const Eigen::MatrixXd>& B);

/// Eigenvalues (ascending) and orthonormal eigenvectors of a symmetric matrix.
struct DenseEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
DenseEigen symmetric_eigen(const Eigen::MatrixXd& A);

/// A x = lambda B x with B positive definite; vectors are B-orthonormal.  std::runtime_error where B is not.
DenseEigen generalized_eigen(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

}  // namespace flexura::linalg
