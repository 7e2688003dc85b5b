// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/complex_factors.hpp"

#include <cmath>
#include <utility>

#include "mbs/base/math/simd.hpp"

namespace flexura::mbs {

namespace {

// Columns of n numbers one after the other.
struct Columns {
  double *re, *im;
  int n;

  FLEXURA_INLINE Columns column(int j) const { return {re + j * n, im + j * n, n}; }
  FLEXURA_INLINE void swap(int i, int k) const {
    std::swap(re[i], re[k]);
    std::swap(im[i], im[k]);
  }
  FLEXURA_INLINE double size(int i) const { return std::abs(re[i]) + std::abs(im[i]); }
  FLEXURA_INLINE void multiply(int i, double by_re, double by_im) const {
    const double x = re[i];
    re[i] = x * by_re - im[i] * by_im;
    im[i] = x * by_im + im[i] * by_re;
  }
};

// y_i -= sum_c L_i,k+c x_c of rows i from `first` on, for K columns from the k-th on.
template <int K>
FLEXURA_INLINE void subtract(const Columns& L, int k, int first, const double* x_re, const double* x_im,
                             const Columns& y) {
  const double *l_re[K], *l_im[K];
  double a[K], b[K];
  for (int c = 0; c < K; ++c) {
    l_re[c] = L.re + (k + c) * L.n;
    l_im[c] = L.im + (k + c) * L.n;
    a[c] = x_re[c];
    b[c] = x_im[c];
  }
  double* __restrict re = y.re, * __restrict im = y.im;
  for (int i = first; i < L.n; ++i) {
    double sum_re = re[i], sum_im = im[i];
    for (int c = 0; c < K; ++c) {
      sum_re -= l_re[c][i] * a[c] - l_im[c][i] * b[c];
      sum_im -= l_re[c][i] * b[c] + l_im[c][i] * a[c];
    }
    re[i] = sum_re;
    im[i] = sum_im;
  }
}

// Takes K columns of L from the k-th on out of y: their own rows one after the other, then all below at once.
template <int K>
FLEXURA_INLINE void eliminate(const Columns& L, int k, const Columns& y) {
  for (int c = 1; c < K; ++c)
    for (int d = 0; d < c; ++d) {
      const int l = (k + d) * L.n + k + c;
      y.re[k + c] -= L.re[l] * y.re[k + d] - L.im[l] * y.im[k + d];
      y.im[k + c] -= L.re[l] * y.im[k + d] + L.im[l] * y.re[k + d];
    }
  subtract<K>(L, k, k + K, y.re + k, y.im + k, y);
}

// The first `count` columns of L.
FLEXURA_INLINE void solve_lower(const Columns& L, int count, const Columns& y) {
  int k = 0;
  for (; k + 4 <= count; k += 4) eliminate<4>(L, k, y);
  for (; k < count; ++k) eliminate<1>(L, k, y);
}

// 1 / y_i, without the square of its size (R. L. Smith, CACM 5 (1962) 435).
FLEXURA_INLINE std::pair<double, double> inverse(const Columns& y, int i) {
  const double re = y.re[i], im = y.im[i];
  if (std::abs(re) >= std::abs(im)) {
    const double part = im / re, size = re + im * part;
    return {1.0 / size, -part / size};
  }
  const double part = re / im, size = re * part + im;
  return {part / size, -1.0 / size};
}

FLEXURA_INLINE void factor(const Columns& A, int* pivot) {
  for (int j = 0; j < A.n; ++j) {
    const Columns y = A.column(j);
    for (int k = 0; k < j; ++k) y.swap(k, pivot[k]);
    solve_lower(A, j, y);
    int p = j;
    double largest = y.size(j);
    for (int i = j + 1; i < A.n; ++i)
      if (const double size = y.size(i); size > largest) p = i, largest = size;
    pivot[j] = p;
    for (int k = 0; k <= j; ++k) A.column(k).swap(j, p);
    const auto [re, im] = inverse(y, j);
    for (int i = j + 1; i < A.n; ++i) y.multiply(i, re, im);
  }
}

FLEXURA_INLINE void solve(const Columns& A, const int* pivot, const Columns& x) {
  for (int k = 0; k < A.n; ++k) x.swap(k, pivot[k]);
  solve_lower(A, A.n, x);
  for (int j = A.n - 1; j >= 0; --j) {
    const Columns u = A.column(j);
    const auto [re, im] = inverse(u, j);
    x.multiply(j, re, im);
    // Rows above the diagonal: of a matrix that ends there.
    subtract<1>({u.re, u.im, j}, 0, 0, x.re + j, x.im + j, {x.re, x.im, j});
  }
}

}  // namespace

void ComplexFactors::compute(const Eigen::MatrixXcd& A) {
  n_ = static_cast<int>(A.rows());
  const auto size = static_cast<std::size_t>(A.size()), n = static_cast<std::size_t>(n_);
  re_.resize(size);
  im_.resize(size);
  x_re_.resize(n);
  x_im_.resize(n);
  pivot_.resize(n);
  for (std::size_t i = 0; i < size; ++i) {
    re_[i] = A.data()[i].real();
    im_[i] = A.data()[i].imag();
  }
  const Columns columns{re_.data(), im_.data(), n_};
  on_this_machine([&]() __attribute__((always_inline)) { factor(columns, pivot_.data()); });
}

void ComplexFactors::solve_in_place(Eigen::VectorXcd& x) {
  for (int i = 0; i < n_; ++i) {
    x_re_[i] = x(i).real();
    x_im_[i] = x(i).imag();
  }
  const Columns columns{re_.data(), im_.data(), n_}, out{x_re_.data(), x_im_.data(), n_};
  on_this_machine([&]() __attribute__((always_inline)) { solve(columns, pivot_.data(), out); });
  for (int i = 0; i < n_; ++i) x(i) = {x_re_[i], x_im_[i]};
}

}  // namespace flexura::mbs
