// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <memory>

#include "reduce/linalg/column_panels.hpp"
#include "reduce/linalg/panel_products.hpp"
#include "reduce/linalg/supernodal_factor.hpp"

namespace flexura::linalg {
namespace {

// The factor's arrays.
struct Arrays {
  int n, n_supernodes;
  const int *first_column, *first_row, *rows, *order;
  const std::int64_t* first_value;
  const double *values, *signs;
};

// The dense matrix of one supernode.
struct Supernode {
  const double* L;
  std::ptrdiff_t height;
  int width;
  const int* rows_below;  // height - width of them
};

FLEXURA_INLINE Supernode supernode(const Arrays& L, int s) {
  const int width = L.first_column[s + 1] - L.first_column[s];
  return {L.values + L.first_value[s], L.first_row[s + 1] - L.first_row[s], width,
          L.rows + L.first_row[s] + width};
}

// Columns k ... k + K of a supernode, forwards: x is its rows of the panel, `below` what goes to the others.
template <int W, int K>
FLEXURA_INLINE void forward_columns(const Supernode& s, int k, typename Lanes<W>::Row* x,
                                    typename Lanes<W>::Row* below) {
  const double* L = s.L + k * s.height;
  for (int c = 0; c < K; ++c) {
    for (int d = 0; d < c; ++d) x[k + c] -= L[d * s.height + k + c] * x[k + d];
    x[k + c] /= L[c * s.height + k + c];
  }
  subtract_product<W, K>(L + k + K, s.height, s.width - k - K, x + k, x + k + K);
  subtract_product<W, K>(L + s.width, s.height, s.height - s.width, x + k, below);
}

template <int W, int K>
FLEXURA_INLINE void backward_columns(const Supernode& s, int k, typename Lanes<W>::Row* x,
                                     const typename Lanes<W>::Row* below) {
  const double* L = s.L + k * s.height;
  subtract_transposed_product<W, K>(L + k + K, s.height, s.width - k - K, x + k + K, x + k);
  subtract_transposed_product<W, K>(L + s.width, s.height, s.height - s.width, below, x + k);
  for (int c = K - 1; c >= 0; --c) {
    for (int d = c + 1; d < K; ++d) x[k + c] -= L[c * s.height + k + d] * x[k + d];
    x[k + c] /= L[c * s.height + k + c];
  }
}

// X = (L S L^T)^-1 X for a panel in the factor's order; `scratch` has room for the rows of any supernode.
template <int W>
FLEXURA_INLINE void solve_panel(const Arrays& L, double* panel, double* scratch) {
  using Row = typename Lanes<W>::Row;
  Row* X = reinterpret_cast<Row*>(panel);
  Row* below = reinterpret_cast<Row*>(scratch);
  for (int i = 0; i < L.n_supernodes; ++i) {
    const Supernode s = supernode(L, i);
    const std::ptrdiff_t n_below = s.height - s.width;
    Row* x = X + L.first_column[i];
    std::fill_n(scratch, n_below * W, 0.0);
    int k = 0;
    for (; k + kPanelColumns <= s.width; k += kPanelColumns)
      forward_columns<W, kPanelColumns>(s, k, x, below);
    for (; k + 3 <= s.width; k += 3) forward_columns<W, 3>(s, k, x, below);
    for (; k < s.width; ++k) forward_columns<W, 1>(s, k, x, below);
    for (std::ptrdiff_t r = 0; r < n_below; ++r) X[s.rows_below[r]] += below[r];
  }
  for (int i = L.n_supernodes - 1; i >= 0; --i) {
    const Supernode s = supernode(L, i);
    const std::ptrdiff_t n_below = s.height - s.width;
    Row* x = X + L.first_column[i];
    for (std::ptrdiff_t r = 0; r < n_below; ++r) below[r] = X[s.rows_below[r]];
    for (int c = 0; c < s.width; ++c) x[c] *= L.signs[L.first_column[i] + c];
    int k = s.width;
    for (; k >= kPanelColumns; k -= kPanelColumns)
      backward_columns<W, kPanelColumns>(s, k - kPanelColumns, x, below);
    for (; k >= 3; k -= 3) backward_columns<W, 3>(s, k - 3, x, below);
    for (; k > 0; --k) backward_columns<W, 1>(s, k - 1, x, below);
  }
}

template <int W>
void solve_columns(const Arrays& L, const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Index first,
                   Eigen::Index count, Eigen::MatrixXd& X) {
  std::ptrdiff_t longest = 0;
  for (int s = 0; s < L.n_supernodes; ++s)
    longest = std::max<std::ptrdiff_t>(longest, L.first_row[s + 1] - L.first_row[s]);
  const std::unique_ptr<double[]> panel(new double[static_cast<std::size_t>(L.n) * W]),
      scratch(new double[static_cast<std::size_t>(longest) * W]);
  double* at = panel.get();
  for (int k = 0; k < L.n; ++k)
    for (int c = 0; c < W; ++c) *at++ = c < count ? B(L.order[k], first + c) : 0.0;
  on_this_machine([&]() __attribute__((always_inline)) { solve_panel<W>(L, panel.get(), scratch.get()); });
  for (int k = 0; k < L.n; ++k)
    for (Eigen::Index c = 0; c < count; ++c)
      X(L.order[k], first + c) = panel[static_cast<std::size_t>(k) * W + static_cast<std::size_t>(c)];
}

}  // namespace

void SupernodalFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::MatrixXd& X) const {
  const Arrays L{n_,           n_supernodes(), first_column_.data(), first_row_.data(),
                 rows_.data(), order_.data(),  first_value_.data(),  values_.get(),
                 signs_.data()};
  X.resize(B.rows(), B.cols());
  for_each_panel(B.cols(), [&](auto width, Eigen::Index first, Eigen::Index count) {
    solve_columns<width>(L, B, first, count, X);
  });
}

}  // namespace flexura::linalg
