// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <memory>

#include "reduce/linalg/dense/column_panels.hpp"
#include "reduce/linalg/dense/panel_products.hpp"
#include "reduce/linalg/factor/supernodal_factor.hpp"

namespace flexura::linalg {
namespace {

// The factor's arrays.
struct Arrays {
  int n, n_supernodes;
  const int *first_column, *first_row, *rows, *order;
  const std::int64_t* first_value;
  const double* signs;
  const FactorStore* values;
  bool single;  // what the numbers are
};

// A supernode: `rows_below` are the rows after its own.
template <class Real>
struct Supernode {
  Trapezoid shape;
  const Real* L;
  const int* rows_below;
};

template <class Real>
FLEXURA_INLINE Supernode<Real> supernode(const Arrays& L, int s) {
  const int width = L.first_column[s + 1] - L.first_column[s];
  return {{L.first_row[s + 1] - L.first_row[s], width},
          static_cast<const Real*>(L.values->data()) + L.first_value[s],
          L.rows + L.first_row[s] + width};
}

// One of its blocks of columns: of `height` rows, the first `width` are the supernode's own from this block
// on.
template <class Real>
struct Block {
  const Real* L;
  std::ptrdiff_t height, width, count;
};

template <class Real>
FLEXURA_INLINE Block<Real> block_of(const Supernode<Real>& s, int b) {
  return {s.L + s.shape.offset(b), s.shape.stride(b), s.shape.width - s.shape.first(b), s.shape.count(b)};
}

// Bytes are fetched from a file this many ahead of their use.
constexpr std::int64_t kAhead = 64'000'000;

// Columns k ... k + K of a block, forwards: x is its own rows of the panel, `below` what goes to the others.
template <int W, int K, class Real>
FLEXURA_INLINE void forward_columns(const Block<Real>& s, std::ptrdiff_t k, typename Lanes<W>::Row* x,
                                    typename Lanes<W>::Row* below) {
  const Real* L = s.L + k * s.height;
  for (int c = 0; c < K; ++c) {
    for (int d = 0; d < c; ++d) x[k + c] -= static_cast<double>(L[d * s.height + k + c]) * x[k + d];
    x[k + c] /= static_cast<double>(L[c * s.height + k + c]);
  }
  subtract_product<W, K>(L + k + K, s.height, s.width - k - K, x + k, x + k + K);
  subtract_product<W, K>(L + s.width, s.height, s.height - s.width, x + k, below);
}

template <int W, int K, class Real>
FLEXURA_INLINE void backward_columns(const Block<Real>& s, std::ptrdiff_t k, typename Lanes<W>::Row* x,
                                     const typename Lanes<W>::Row* below) {
  const Real* L = s.L + k * s.height;
  subtract_transposed_product<W, K>(L + k + K, s.height, s.width - k - K, x + k + K, x + k);
  subtract_transposed_product<W, K>(L + s.width, s.height, s.height - s.width, below, x + k);
  for (int c = K - 1; c >= 0; --c) {
    for (int d = c + 1; d < K; ++d) x[k + c] -= static_cast<double>(L[c * s.height + k + d]) * x[k + d];
    x[k + c] /= static_cast<double>(L[c * s.height + k + c]);
  }
}

// X = (L S L^T)^-1 X for a panel in the factor's order; `scratch` has room for the rows of any supernode.
template <int W, class Real>
FLEXURA_INLINE void solve_panel(const Arrays& L, double* panel, double* scratch) {
  using Row = typename Lanes<W>::Row;
  Row* X = reinterpret_cast<Row*>(panel);
  Row* below = reinterpret_cast<Row*>(scratch);
  constexpr auto kSize = static_cast<std::int64_t>(sizeof(Real));
  const std::int64_t end = kSize * L.first_value[L.n_supernodes];
  std::int64_t fetched = 0;
  for (int i = 0; i < L.n_supernodes; ++i) {
    if (const std::int64_t wanted = std::min(end, kSize * L.first_value[i + 1] + kAhead);
        wanted - fetched >= kAhead / 2) {
      L.values->will_need(fetched, wanted - fetched);
      fetched = wanted;
    }
    const Supernode<Real> s = supernode<Real>(L, i);
    const std::ptrdiff_t n_below = s.shape.height - s.shape.width;
    std::fill_n(scratch, n_below * W, 0.0);
    for (int b = 0; b < s.shape.n_blocks(); ++b) {
      const Block<Real> block = block_of(s, b);
      Row* x = X + L.first_column[i] + s.shape.first(b);
      std::ptrdiff_t k = 0;
      for (; k + kPanelColumns <= block.count; k += kPanelColumns)
        forward_columns<W, kPanelColumns>(block, k, x, below);
      for (; k + 3 <= block.count; k += 3) forward_columns<W, 3>(block, k, x, below);
      for (; k < block.count; ++k) forward_columns<W, 1>(block, k, x, below);
    }
    for (std::ptrdiff_t r = 0; r < n_below; ++r) X[s.rows_below[r]] += below[r];
  }
  fetched = end;
  for (int i = L.n_supernodes - 1; i >= 0; --i) {
    if (const std::int64_t wanted = std::max<std::int64_t>(0, kSize * L.first_value[i] - kAhead);
        fetched - wanted >= kAhead / 2) {
      L.values->will_need(wanted, fetched - wanted);
      fetched = wanted;
    }
    const Supernode<Real> s = supernode<Real>(L, i);
    const std::ptrdiff_t n_below = s.shape.height - s.shape.width;
    for (std::ptrdiff_t r = 0; r < n_below; ++r) below[r] = X[s.rows_below[r]];
    for (std::ptrdiff_t c = 0; c < s.shape.width; ++c)
      X[L.first_column[i] + c] *= L.signs[L.first_column[i] + c];
    for (int b = s.shape.n_blocks() - 1; b >= 0; --b) {
      const Block<Real> block = block_of(s, b);
      Row* x = X + L.first_column[i] + s.shape.first(b);
      std::ptrdiff_t k = block.count;
      for (; k >= kPanelColumns; k -= kPanelColumns)
        backward_columns<W, kPanelColumns>(block, k - kPanelColumns, x, below);
      for (; k >= 3; k -= 3) backward_columns<W, 3>(block, k - 3, x, below);
      for (; k > 0; --k) backward_columns<W, 1>(block, k - 1, x, below);
    }
  }
}

template <int W>
void solve_columns(const Arrays& L, const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::Index first,
                   Eigen::Index count, Eigen::Ref<Eigen::MatrixXd>& X) {
  std::ptrdiff_t longest = 0;
  for (int s = 0; s < L.n_supernodes; ++s)
    longest = std::max<std::ptrdiff_t>(longest, L.first_row[s + 1] - L.first_row[s]);
  const std::unique_ptr<double[]> panel(new double[static_cast<std::size_t>(L.n) * W]),
      scratch(new double[static_cast<std::size_t>(longest) * W]);
  double* at = panel.get();
  for (int k = 0; k < L.n; ++k)
    for (int c = 0; c < W; ++c) *at++ = c < count ? B(L.order[k], first + c) : 0.0;
  on_this_machine([&]() __attribute__((always_inline)) {
    if (L.single)
      solve_panel<W, float>(L, panel.get(), scratch.get());
    else
      solve_panel<W, double>(L, panel.get(), scratch.get());
  });
  for (int k = 0; k < L.n; ++k)
    for (Eigen::Index c = 0; c < count; ++c)
      X(L.order[k], first + c) = panel[static_cast<std::size_t>(k) * W + static_cast<std::size_t>(c)];
}

}  // namespace

void SupernodalFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::MatrixXd& X) const {
  X.resize(B.rows(), B.cols());
  solve_into(B, X);
}

void SupernodalFactor::solve_into(const Eigen::Ref<const Eigen::MatrixXd>& B,
                                  Eigen::Ref<Eigen::MatrixXd> X) const {
  const Arrays L{n_,           n_supernodes(), first_column_.data(), first_row_.data(),
                 rows_.data(), order_.data(),  first_value_.data(),  signs_.data(),
                 &values_,     single_};
  for_each_panel(B.cols(), [&](auto width, Eigen::Index first, Eigen::Index count) {
    solve_columns<width>(L, B, first, count, X);
  });
}

}  // namespace flexura::linalg
