// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/supernodal_solve.hpp"

#include <algorithm>
#include <memory>

#include "reduce/linalg/parallel.hpp"

namespace flexura::linalg {
namespace {

#define FLEXURA_INLINE inline __attribute__((always_inline))

// One row of a panel of W right-hand sides; compilers turn it into the widest registers there are.
template <int W>
struct Panel {
  typedef double Row __attribute__((vector_size(8 * W)));
};

// Columns of L taken together: with eight right-hand sides their coefficients just fit the 16 registers of
// AVX2.
constexpr int kColumns = 6;

// The dense matrix of one supernode.
struct Supernode {
  const double* L;
  std::ptrdiff_t height;
  int width;
  const int* rows_below;  // height - width of them
};

FLEXURA_INLINE Supernode supernode(const SupernodalFactor& L, int s) {
  const int width = L.first_column[s + 1] - L.first_column[s];
  return {L.values + L.first_value[s], L.first_row[s + 1] - L.first_row[s], width,
          L.rows + L.first_row[s] + width};
}

// Y_i -= sum_c L_ic x_c for n rows i and K columns c.
template <int W, int K>
FLEXURA_INLINE void subtract_product(const double* L, std::ptrdiff_t height, std::ptrdiff_t n,
                                     const typename Panel<W>::Row* x, typename Panel<W>::Row* Y) {
  typename Panel<W>::Row known[K];
  for (int c = 0; c < K; ++c) known[c] = x[c];
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    typename Panel<W>::Row y = Y[i];
    for (int c = 0; c < K; ++c) y -= L[i + c * height] * known[c];
    Y[i] = y;
  }
}

// x_c -= sum_i L_ic Y_i.
template <int W, int K>
FLEXURA_INLINE void subtract_transposed_product(const double* L, std::ptrdiff_t height, std::ptrdiff_t n,
                                                const typename Panel<W>::Row* Y, typename Panel<W>::Row* x) {
  typename Panel<W>::Row sum[K];
  for (int c = 0; c < K; ++c) sum[c] = x[c];
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const typename Panel<W>::Row y = Y[i];
    for (int c = 0; c < K; ++c) sum[c] -= L[i + c * height] * y;
  }
  for (int c = 0; c < K; ++c) x[c] = sum[c];
}

// Columns k ... k + K of a supernode, forwards: x is its rows of the panel, `below` what goes to the others.
template <int W, int K>
FLEXURA_INLINE void forward_columns(const Supernode& s, int k, typename Panel<W>::Row* x,
                                    typename Panel<W>::Row* below) {
  const double* L = s.L + k * s.height;
  for (int c = 0; c < K; ++c) {
    for (int d = 0; d < c; ++d) x[k + c] -= L[d * s.height + k + c] * x[k + d];
    x[k + c] /= L[c * s.height + k + c];
  }
  subtract_product<W, K>(L + k + K, s.height, s.width - k - K, x + k, x + k + K);
  subtract_product<W, K>(L + s.width, s.height, s.height - s.width, x + k, below);
}

template <int W, int K>
FLEXURA_INLINE void backward_columns(const Supernode& s, int k, typename Panel<W>::Row* x,
                                     const typename Panel<W>::Row* below) {
  const double* L = s.L + k * s.height;
  subtract_transposed_product<W, K>(L + k + K, s.height, s.width - k - K, x + k + K, x + k);
  subtract_transposed_product<W, K>(L + s.width, s.height, s.height - s.width, below, x + k);
  for (int c = K - 1; c >= 0; --c) {
    for (int d = c + 1; d < K; ++d) x[k + c] -= L[c * s.height + k + d] * x[k + d];
    x[k + c] /= L[c * s.height + k + c];
  }
}

// L L^T x = x for a panel in the factor's order; `below` holds the longest supernode's rows.
template <int W>
FLEXURA_INLINE void solve_panel(const SupernodalFactor& L, typename Panel<W>::Row* X,
                                typename Panel<W>::Row* below) {
  for (int i = 0; i < L.n_supernodes; ++i) {
    const Supernode s = supernode(L, i);
    const std::ptrdiff_t n_below = s.height - s.width;
    typename Panel<W>::Row* x = X + L.first_column[i];
    std::fill_n(below, n_below, typename Panel<W>::Row{});
    int k = 0;
    for (; k + kColumns <= s.width; k += kColumns) forward_columns<W, kColumns>(s, k, x, below);
    for (; k + 3 <= s.width; k += 3) forward_columns<W, 3>(s, k, x, below);
    for (; k < s.width; ++k) forward_columns<W, 1>(s, k, x, below);
    for (std::ptrdiff_t r = 0; r < n_below; ++r) X[s.rows_below[r]] += below[r];
  }
  for (int i = L.n_supernodes - 1; i >= 0; --i) {
    const Supernode s = supernode(L, i);
    const std::ptrdiff_t n_below = s.height - s.width;
    typename Panel<W>::Row* x = X + L.first_column[i];
    for (std::ptrdiff_t r = 0; r < n_below; ++r) below[r] = X[s.rows_below[r]];
    int k = s.width;
    for (; k >= kColumns; k -= kColumns) backward_columns<W, kColumns>(s, k - kColumns, x, below);
    for (; k >= 3; k -= 3) backward_columns<W, 3>(s, k - 3, x, below);
    for (; k > 0; --k) backward_columns<W, 1>(s, k - 1, x, below);
  }
}

// The same for the machine at hand: programs are built for any x86-64, whose registers hold two numbers.
template <int W>
void solve_panel_anywhere(const SupernodalFactor& L, typename Panel<W>::Row* X,
                          typename Panel<W>::Row* below) {
  solve_panel<W>(L, X, below);
}

#ifdef __x86_64__
template <int W>
__attribute__((target("avx2,fma"))) void solve_panel_avx2(const SupernodalFactor& L,
                                                          typename Panel<W>::Row* X,
                                                          typename Panel<W>::Row* below) {
  solve_panel<W>(L, X, below);
}
#endif

template <int W>
void solve_columns(const SupernodalFactor& L, const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Index first,
                   Eigen::Index count, Eigen::MatrixXd& X) {
  using Row = typename Panel<W>::Row;
  std::ptrdiff_t n_below = 0;
  for (int s = 0; s < L.n_supernodes; ++s)
    n_below = std::max<std::ptrdiff_t>(n_below, supernode(L, s).height - supernode(L, s).width);
  const std::unique_ptr<Row[]> panel(new Row[static_cast<std::size_t>(L.n)]), below(new Row[n_below]);
  for (int k = 0; k < L.n; ++k) {
    const int row = L.permutation[k];
    for (int c = 0; c < W; ++c) panel[k][c] = c < count ? B(row, first + c) : 0.0;
  }
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
    solve_panel_avx2<W>(L, panel.get(), below.get());
  else
#endif
    solve_panel_anywhere<W>(L, panel.get(), below.get());
  for (int k = 0; k < L.n; ++k) {
    const int row = L.permutation[k];
    for (int c = 0; c < count; ++c) X(row, first + c) = panel[k][c];
  }
}

}  // namespace

void supernodal_solve(const SupernodalFactor& L, const Eigen::Ref<const Eigen::MatrixXd>& B,
                      Eigen::MatrixXd& X) {
  X.resize(B.rows(), B.cols());
  const Eigen::Index n_cols = B.cols();
  const int width = n_cols > 8 ? 8 : 4;
  parallel_for(static_cast<int>((n_cols + width - 1) / width), [&](int p) {
    const Eigen::Index first = static_cast<Eigen::Index>(p) * width,
                       count = std::min<Eigen::Index>(width, n_cols - first);
    if (width == 8)
      solve_columns<8>(L, B, first, count, X);
    else
      solve_columns<4>(L, B, first, count, X);
  });
}

}  // namespace flexura::linalg
