// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/dense/dense.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "reduce/linalg/dense/blas.hpp"
#include "reduce/linalg/dense/blas_threads.hpp"
#include "reduce/linalg/dense/panel_products.hpp"
#include "reduce/linalg/dense/parallel.hpp"

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

// Rows that one core takes of a tall matrix: all cores have their share, and short ones are not cut.
int n_shares(Eigen::Index n_rows) {
  constexpr Eigen::Index kFewest = 4096;
  return static_cast<int>(std::clamp<Eigen::Index>(n_rows / kFewest, 1, n_cores()));
}

// The products with few columns, on one core's share: by chunks of rows whose panels stay in the first cache.
// Panels of eight columns lie one after the other, each stored by rows.
constexpr Eigen::Index kWidth = 8, kFew = 32, kChunk = 128;

using Ref = Eigen::Ref<const Eigen::MatrixXd>;
using Row = Lanes<kWidth>::Row;

// Columns, filled up to whole panels.
Eigen::Index padded(Eigen::Index n_cols) {
  return (n_cols + kWidth - 1) / kWidth * kWidth;
}

FLEXURA_INLINE void load_panels(const Ref& X, Eigen::Index first, Eigen::Index n, double factor,
                                double* panels) {
  for (Eigen::Index c = 0; c < padded(X.cols()); ++c) {
    double* column = panels + c / kWidth * n * kWidth + c % kWidth;
    for (Eigen::Index i = 0; i < n; ++i) column[i * kWidth] = c < X.cols() ? factor * X(first + i, c) : 0.0;
  }
}

template <class Matrix>
FLEXURA_INLINE void store_panels(const double* panels, Eigen::Index first, Eigen::Index n, Matrix& X) {
  if (n == 0) return;  // there are no panels
  for (Eigen::Index c = 0; c < X.cols(); ++c) {
    const double* column = panels + c / kWidth * n * kWidth + c % kWidth;
    for (Eigen::Index i = 0; i < n; ++i) X(first + i, c) = column[i * kWidth];
  }
}

// C -= A^T B, C in panels.
FLEXURA_INLINE void transposed_share(const Ref& A, const Ref& B, double* C) {
  alignas(64) double panels[kChunk * kFew];
  const Eigen::Index lda = A.outerStride(), n_cols = padded(B.cols());
  for (Eigen::Index first = 0; first < A.rows(); first += kChunk) {
    const Eigen::Index n = std::min(kChunk, A.rows() - first);
    load_panels(B, first, n, 1.0, panels);
    for (Eigen::Index k = 0; k < A.cols();) {
      const bool whole = k + kPanelColumns <= A.cols();
      const double* a = A.data() + first + k * lda;
      for (Eigen::Index p = 0; p < n_cols; p += kWidth) {
        const Row* b = reinterpret_cast<const Row*>(panels + p * n);
        Row* c = reinterpret_cast<Row*>(C + p * A.cols()) + k;
        if (whole)
          subtract_transposed_product<kWidth, kPanelColumns>(a, lda, n, b, c);
        else
          subtract_transposed_product<kWidth, 1>(a, lda, n, b, c);
      }
      k += whole ? kPanelColumns : 1;
    }
  }
}

// C -= A B, B in panels.
FLEXURA_INLINE void product_share(const Ref& A, const double* B, Eigen::Ref<Eigen::MatrixXd>& C) {
  alignas(64) double panels[kChunk * kFew];
  const Eigen::Index lda = A.outerStride(), n_cols = padded(C.cols());
  for (Eigen::Index first = 0; first < A.rows(); first += kChunk) {
    const Eigen::Index n = std::min(kChunk, A.rows() - first);
    load_panels(C, first, n, 1.0, panels);
    for (Eigen::Index k = 0; k < A.cols();) {
      const bool whole = k + kPanelColumns <= A.cols();
      const double* a = A.data() + first + k * lda;
      for (Eigen::Index p = 0; p < n_cols; p += kWidth) {
        const Row* b = reinterpret_cast<const Row*>(B + p * A.cols()) + k;
        Row* c = reinterpret_cast<Row*>(panels + p * n);
        if (whole)
          subtract_product<kWidth, kPanelColumns>(a, lda, n, b, c);
        else
          subtract_product<kWidth, 1>(a, lda, n, b, c);
      }
      k += whole ? kPanelColumns : 1;
    }
    store_panels(panels, first, n, C);
  }
}

// LAPACK may return NaN as if it had converged.
void require_finite(const Eigen::MatrixXd& A) {
  if (!A.allFinite())
    throw std::runtime_error(fmt::format("a small eigenproblem of {} rows holds NaN or infinity", A.rows()));
}

}  // namespace

Eigen::MatrixXd transpose_times(const Eigen::Ref<const Eigen::MatrixXd>& A,
                                const Eigen::Ref<const Eigen::MatrixXd>& B) {
  if (A.rows() != B.rows()) throw std::logic_error("transpose_times: the heights differ");
  const int n = n_shares(A.rows());
  const bool few = B.cols() <= kFew;
  std::vector<Eigen::MatrixXd> C(n);
  const OneBlasThread one;
  parallel_for(n, [&](int k) {
    const Eigen::Index first = A.rows() * k / n, height = A.rows() * (k + 1) / n - first;
    const Ref a = A.middleRows(first, height), b = B.middleRows(first, height);
    C[k].setZero(A.cols(), B.cols());
    if (!few) {
      gemm('T', 'N', 1.0, a, b, 0.0, C[k]);
      return;
    }
    std::vector<double> panels(static_cast<std::size_t>(padded(B.cols()) * A.cols()), 0.0);
    on_wide_registers([&]() __attribute__((always_inline)) { transposed_share(a, b, panels.data()); });
    store_panels(panels.data(), 0, A.cols(), C[k]);
    C[k] = -C[k];
  });
  for (int k = 1; k < n; ++k) C[0] += C[k];
  return std::move(C[0]);
}

void add_product(double alpha, const Eigen::Ref<const Eigen::MatrixXd>& A,
                 const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Ref<Eigen::MatrixXd> C) {
  if (A.cols() != B.rows() || A.rows() != C.rows() || B.cols() != C.cols())
    throw std::logic_error("add_product: the sizes differ");
  const int n = n_shares(A.rows());
  const bool few = B.cols() <= kFew;
  std::vector<double> panels(few ? static_cast<std::size_t>(padded(B.cols()) * A.cols()) : 0);
  if (few) load_panels(B, 0, B.rows(), -alpha, panels.data());
  const OneBlasThread one;
  parallel_for(n, [&](int k) {
    const Eigen::Index first = A.rows() * k / n, height = A.rows() * (k + 1) / n - first;
    const Ref a = A.middleRows(first, height);
    Eigen::Ref<Eigen::MatrixXd> c = C.middleRows(first, height);
    if (few)
      on_wide_registers([&]() __attribute__((always_inline)) { product_share(a, panels.data(), c); });
    else
      gemm('N', 'N', alpha, a, B, 1.0, c);
  });
}

Eigen::MatrixXd times(const Eigen::Ref<const Eigen::MatrixXd>& A,
                      const Eigen::Ref<const Eigen::MatrixXd>& B) {
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(A.rows(), B.cols());
  add_product(1.0, A, B, C);
  return C;
}

DenseEigen symmetric_eigen(const Eigen::MatrixXd& A) {
  require_finite(A);
  DenseEigen result{Eigen::VectorXd(A.rows()), A};
  const int n = static_cast<int>(A.rows()), query = -1;
  if (n == 0) return result;
  int info = 0, n_iwork = 0;
  double n_work = 0.0;
  const OneBlasThread one;
  dsyevd_("V", "L", &n, result.vectors.data(), &n, result.values.data(), &n_work, &query, &n_iwork, &query,
          &info);
  std::vector<double> work(static_cast<std::size_t>(n_work));
  std::vector<int> iwork(n_iwork);
  const int lwork = static_cast<int>(work.size()), liwork = n_iwork;
  dsyevd_("V", "L", &n, result.vectors.data(), &n, result.values.data(), work.data(), &lwork, iwork.data(),
          &liwork, &info);
  if (info == 0) return result;
  // Divide and conquer may fail where plain QR does not.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> plain(A);
  if (plain.info() != Eigen::Success)
    throw std::runtime_error(fmt::format("a small symmetric eigenproblem of {} rows did not converge", n));
  return {plain.eigenvalues(), plain.eigenvectors()};
}

DenseEigen generalized_eigen(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  require_finite(A);
  require_finite(B);
  DenseEigen result{Eigen::VectorXd(A.rows()), A};
  Eigen::MatrixXd b = B;
  const int n = static_cast<int>(A.rows()), query = -1, type = 1;
  if (n == 0) return result;
  int info = 0, n_iwork = 0;
  double n_work = 0.0;
  const OneBlasThread one;
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
    throw std::runtime_error(fmt::format("a small generalized eigenproblem of {} rows did not converge", n));
  return result;
}

}  // namespace flexura::linalg
