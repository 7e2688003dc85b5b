// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/dense.hpp"

#include <stdexcept>
#include <string>
#include <vector>

extern "C" {
void dgemm_(const char*, const char*, const int*, const int*, const int*, const double*, const double*,
            const int*, const double*, const int*, const double*, double*, const int*);
void dsyevd_(const char*, const char*, const int*, double*, const int*, double*, double*, const int*, int*,
             const int*, int*);
void dsygvd_(const int*, const char*, const char*, const int*, double*, const int*, double*, const int*,
             double*, double*, const int*, int*, const int*, int*);
}

namespace flexura::linalg {
namespace {

void gemm(char transA, char transB, double alpha, const Eigen::Ref<const Eigen::MatrixXd>& A,
          const Eigen::Ref<const Eigen::MatrixXd>& B, double beta, Eigen::Ref<Eigen::MatrixXd> C) {
  const int m = static_cast<int>(C.rows()), n = static_cast<int>(C.cols());
  const int k = static_cast<int>(transA == 'N' ? A.cols() : A.rows());
  if (m == 0 || n == 0) return;
  if (k == 0) {
    C *= beta;
    return;
  }
  const int lda = static_cast<int>(A.outerStride()), ldb = static_cast<int>(B.outerStride()),
            ldc = static_cast<int>(C.outerStride());
  dgemm_(&transA, &transB, &m, &n, &k, &alpha, A.data(), &lda, B.data(), &ldb, &beta, C.data(), &ldc);
}

}  // namespace

Eigen::MatrixXd transpose_times(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                const Eigen::Ref<const Eigen::MatrixXd>& B) {
  if (A.rows() != B.rows()) throw std::logic_error("transpose_times: the heights differ");
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(A.cols(), B.cols());
  gemm('T', 'N', 1.0, A, B, 0.0, C);
  return C;
}

void add_product(double alpha, const Eigen::Ref<const Eigen::MatrixXd>& A,
                 const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> C) {
  if (A.cols() != B.rows() || A.rows() != C.rows() || B.cols() != C.cols())
    throw std::logic_error("add_product: the sizes differ");
  gemm('N', 'N', alpha, A, B, 1.0, C);
}

Eigen::MatrixXd times(const Eigen::Ref<const Eigen::MatrixXd>& A,
                      const Eigen::Ref<const Eigen::MatrixXd>& B) {
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(A.rows(), B.cols());
  add_product(1.0, A, B, C);
  return C;
}

DenseEigen symmetric_eigen(const Eigen::MatrixXd& A) {
  DenseEigen result{Eigen::VectorXd(A.rows()), A};
  const int n = static_cast<int>(A.rows()), query = -1;
  if (n == 0) return result;
  int info = 0, n_iwork = 0;
  double n_work = 0.0;
  dsyevd_("V", "L", &n, result.vectors.data(), &n, result.values.data(), &n_work, &query, &n_iwork, &query,
          &info);
  std::vector<double> work(static_cast<std::size_t>(n_work));
  std::vector<int> iwork(n_iwork);
  const int lwork = static_cast<int>(work.size()), liwork = n_iwork;
  dsyevd_("V", "L", &n, result.vectors.data(), &n, result.values.data(), work.data(), &lwork, iwork.data(),
          &liwork, &info);
  if (info != 0)
    throw std::runtime_error("a small symmetric eigenproblem did not converge: its matrix holds NaN?");
  return result;
}

DenseEigen generalized_eigen(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  DenseEigen result{Eigen::VectorXd(A.rows()), A};
  Eigen::MatrixXd b = B;
  const int n = static_cast<int>(A.rows()), query = -1, type = 1;
  if (n == 0) return result;
  int info = 0, n_iwork = 0;
  double n_work = 0.0;
  dsygvd_(&type, "V", "L", &n, result.vectors.data(), &n, b.data(), &n, result.values.data(), &n_work, &query,
          &n_iwork, &query, &info);
  std::vector<double> work(static_cast<std::size_t>(n_work));
  std::vector<int> iwork(n_iwork);
  const int lwork = static_cast<int>(work.size()), liwork = n_iwork;
  dsygvd_(&type, "V", "L", &n, result.vectors.data(), &n, b.data(), &n, result.values.data(), work.data(),
          &lwork, iwork.data(), &liwork, &info);
  if (info > n)
    throw std::runtime_error("the mass matrix of a small eigenproblem is not positive definite (row " +
                             std::to_string(info - n) + ")");
  if (info != 0)
    throw std::runtime_error("a small generalized eigenproblem did not converge: its matrices hold NaN?");
  return result;
}

}  // namespace flexura::linalg
