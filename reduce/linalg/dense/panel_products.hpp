// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "mbs/base/math/simd.hpp"

/// Products of a tall matrix stored by columns with a panel of W vectors stored by rows, the inner loops of
/// solves and of orthogonalisation.  An entry of the tall matrix is read once and meets W numbers that lie
/// together; nothing is packed first, which is what few vectors cost most in a general BLAS.
namespace flexura::linalg {

/// Columns taken together: with eight vectors their coefficients just fit the 16 registers of AVX2.
inline constexpr int kPanelColumns = 6;

/// Asks for eight rows of the K columns that follow: pieces of columns are too short for the processor to see ahead by itself.
template <int K, class Real>
FLEXURA_INLINE void ask_for_next(const Real* A, std::ptrdiff_t height, std::ptrdiff_t i) {
  for (int c = 0; c < K; ++c) __builtin_prefetch(A + i + (c + K) * height);
}

/// Y_i -= sum_c A_ic x_c for n rows i and K columns c, `height` apart.  Real: what A is stored as.
template <int W, int K, class Real>
FLEXURA_INLINE void subtract_product(const Real* A, std::ptrdiff_t height, std::ptrdiff_t n,
                                     const typename Lanes<W>::Row* x, typename Lanes<W>::Row* Y) {
  typename Lanes<W>::Row known[K];
  for (int c = 0; c < K; ++c) known[c] = x[c];
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (i % 8 == 0) ask_for_next<K>(A, height, i);
    typename Lanes<W>::Row y = Y[i];
    for (int c = 0; c < K; ++c) y -= static_cast<double>(A[i + c * height]) * known[c];
    Y[i] = y;
  }
}

/// x_c -= sum_i A_ic Y_i.
template <int W, int K, class Real>
FLEXURA_INLINE void subtract_transposed_product(const Real* A, std::ptrdiff_t height, std::ptrdiff_t n,
                                                const typename Lanes<W>::Row* Y, typename Lanes<W>::Row* x) {
  typename Lanes<W>::Row sum[K];
  for (int c = 0; c < K; ++c) sum[c] = x[c];
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (i % 8 == 0) ask_for_next<K>(A, height, i);
    const typename Lanes<W>::Row y = Y[i];
    for (int c = 0; c < K; ++c) sum[c] -= static_cast<double>(A[i + c * height]) * y;
  }
  for (int c = 0; c < K; ++c) x[c] = sum[c];
}

}  // namespace flexura::linalg
