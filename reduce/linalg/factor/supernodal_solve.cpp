// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cstring>
#include <memory>

#include "reduce/linalg/dense/panel_products.hpp"
#include "reduce/linalg/dense/parallel.hpp"
#include "reduce/linalg/factor/supernodal_factor.hpp"

// Subtrees of the elimination tree run on all cores side by side, each reading its part of L once for all panels of
// right-hand sides; what they add to the rows above waits in arrays of their own.  The supernodes above are shared by
// rows.
namespace flexura::linalg {
namespace {

// The factor's arrays.
struct Arrays {
  int n, n_supernodes;
  const int *first_column, *first_row, *rows, *order;
  const std::int64_t* first_value;
  const double* signs;
  const FactorStore* values;
  const SolvePlan* plan;

  int width(int s) const { return first_column[s + 1] - first_column[s]; }
  int height(int s) const { return first_row[s + 1] - first_row[s]; }
  std::ptrdiff_t n_below(int s) const { return height(s) - width(s); }
  const int* rows_below(int s) const { return rows + first_row[s] + width(s); }
};

// Right-hand sides in panels of W that lie together, in the factor's order.
template <int W>
struct Panels {
  using Row = typename Lanes<W>::Row;
  Row* first;
  std::ptrdiff_t rows;  // of each
  int count;
  Row* operator[](int p) const { return first + p * rows; }
};

template <int W>
class OwnPanels {
 public:
  OwnPanels(std::ptrdiff_t rows, int count)
      : numbers_(new double[static_cast<std::size_t>(rows * count * W)]), rows_(rows), count_(count) {}
  Panels<W> get() const { return {reinterpret_cast<typename Lanes<W>::Row*>(numbers_.get()), rows_, count_}; }
  void set_zero() { std::fill_n(numbers_.get(), rows_ * count_ * W, 0.0); }

 private:
  std::unique_ptr<double[]> numbers_;
  std::ptrdiff_t rows_;
  int count_;
};

// A block of a supernode's columns: of `height` rows, the first `count` are its own.
template <class Real>
struct Block {
  const Real* L;
  std::ptrdiff_t height, count, first;  // first: of its columns in the supernode
};

template <class Real>
FLEXURA_INLINE Block<Real> block_of(const Arrays& L, int s, int b) {
  const Trapezoid shape{L.height(s), L.width(s)};
  return {static_cast<const Real*>(L.values->data()) + L.first_value[s] + shape.offset(b), shape.stride(b),
          shape.count(b), Trapezoid::first(b)};
}

FLEXURA_INLINE int n_blocks(const Arrays& L, int s) {
  return Trapezoid{L.height(s), L.width(s)}.n_blocks();
}

// Rows of L that meet all panels while these are in the first cache.
FLEXURA_INLINE std::ptrdiff_t rows_together(int panels) {
  return panels > 1 ? 128 : 256;
}

// Calls step(k, K) for columns k ... k + K of a block, first to last or last to first.
template <class Step>
FLEXURA_INLINE void upwards(std::ptrdiff_t count, const Step& step) {
  std::ptrdiff_t k = 0;
  for (; k + kPanelColumns <= count; k += kPanelColumns)
    step(k, std::integral_constant<int, kPanelColumns>());
  for (; k + 3 <= count; k += 3) step(k, std::integral_constant<int, 3>());
  for (; k < count; ++k) step(k, std::integral_constant<int, 1>());
}
template <class Step>
FLEXURA_INLINE void downwards(std::ptrdiff_t count, const Step& step) {
  std::ptrdiff_t k = count;
  for (; k >= kPanelColumns; k -= kPanelColumns)
    step(k - kPanelColumns, std::integral_constant<int, kPanelColumns>());
  for (; k >= 3; k -= 3) step(k - 3, std::integral_constant<int, 3>());
  for (; k > 0; --k) step(k - 1, std::integral_constant<int, 1>());
}

// The block's own rows, forwards: v is the supernode's rows of the panels.
template <int W, class Real>
FLEXURA_INLINE void forward_triangle(const Block<Real>& block, const Panels<W>& v) {
  upwards(
      block.count, [&](std::ptrdiff_t k, auto width) __attribute__((always_inline)) {
        constexpr int K = width;
        const Real* L = block.L + k * block.height;
        for (int p = 0; p < v.count; ++p) {
          typename Panels<W>::Row* x = v[p] + block.first + k;
          for (int c = 0; c < K; ++c) {
            for (int d = 0; d < c; ++d) x[c] -= static_cast<double>(L[d * block.height + k + c]) * x[d];
            x[c] /= static_cast<double>(L[c * block.height + k + c]);
          }
          subtract_product<W, K>(L + k + K, block.height, block.count - k - K, x, x + K);
        }
      });
}

template <int W, class Real>
FLEXURA_INLINE void backward_triangle(const Block<Real>& block, const Panels<W>& v) {
  downwards(
      block.count, [&](std::ptrdiff_t k, auto width) __attribute__((always_inline)) {
        constexpr int K = width;
        const Real* L = block.L + k * block.height;
        for (int p = 0; p < v.count; ++p) {
          typename Panels<W>::Row* x = v[p] + block.first + k;
          subtract_transposed_product<W, K>(L + k + K, block.height, block.count - k - K, x + K, x);
          for (int c = K - 1; c >= 0; --c) {
            for (int d = c + 1; d < K; ++d) x[c] -= static_cast<double>(L[c * block.height + k + d]) * x[d];
            x[c] /= static_cast<double>(L[c * block.height + k + c]);
          }
        }
      });
}

// Rows begin ... end of the block, counted from below its own, forwards.
template <int W, class Real>
FLEXURA_INLINE void forward_rows(const Block<Real>& block, std::ptrdiff_t begin, std::ptrdiff_t end,
                                 const Panels<W>& v) {
  const std::ptrdiff_t chunk = rows_together(v.count);
  for (std::ptrdiff_t r = block.count + begin; r < block.count + end; r += chunk) {
    const std::ptrdiff_t n = std::min(chunk, block.count + end - r);
    upwards(
        block.count, [&](std::ptrdiff_t k, auto width) __attribute__((always_inline)) {
          for (int p = 0; p < v.count; ++p)
            subtract_product<W, width>(block.L + k * block.height + r, block.height, n,
                                       v[p] + block.first + k, v[p] + block.first + r);
        });
  }
}

// x -= L^T v of such rows; x is the block's own rows of each panel.
template <int W, class Real>
FLEXURA_INLINE void backward_rows(const Block<Real>& block, std::ptrdiff_t begin, std::ptrdiff_t end,
                                  const Panels<W>& v, const Panels<W>& x) {
  const std::ptrdiff_t chunk = rows_together(v.count);
  for (std::ptrdiff_t r = block.count + begin; r < block.count + end; r += chunk) {
    const std::ptrdiff_t n = std::min(chunk, block.count + end - r);
    upwards(
        block.count, [&](std::ptrdiff_t k, auto width) __attribute__((always_inline)) {
          for (int p = 0; p < v.count; ++p)
            subtract_transposed_product<W, width>(block.L + k * block.height + r, block.height, n,
                                                  v[p] + block.first + r, x[p] + k);
        });
  }
}

// Its own rows come from X, the others are 0.
template <int W>
FLEXURA_INLINE void begin_forward(const Arrays& L, int s, const Panels<W>& X, const Panels<W>& v) {
  for (int p = 0; p < X.count; ++p) {
    std::memcpy(v[p], X[p] + L.first_column[s], sizeof(*X.first) * static_cast<std::size_t>(L.width(s)));
    std::memset(v[p] + L.width(s), 0, sizeof(*X.first) * static_cast<std::size_t>(L.n_below(s)));
  }
}

template <int W>
FLEXURA_INLINE void begin_backward(const Arrays& L, int s, const Panels<W>& X, const Panels<W>& v) {
  const int* below = L.rows_below(s);
  const double* signs = L.signs + L.first_column[s];
  for (int p = 0; p < X.count; ++p) {
    for (std::ptrdiff_t c = 0; c < L.width(s); ++c) v[p][c] = X[p][L.first_column[s] + c] * signs[c];
    for (std::ptrdiff_t r = 0; r < L.n_below(s); ++r) v[p][L.width(s) + r] = X[p][below[r]];
  }
}

template <int W>
FLEXURA_INLINE void store_own(const Arrays& L, int s, const Panels<W>& X, const Panels<W>& v) {
  for (int p = 0; p < X.count; ++p)
    std::memcpy(X[p] + L.first_column[s], v[p], sizeof(*X.first) * static_cast<std::size_t>(L.width(s)));
}

// Asks for numbers of L ahead of their use where they are in a file.
template <class Real>
class Ahead {
 public:
  // Supernodes first ... last are read in this order or in the opposite one.
  Ahead(const Arrays& L, int first, int last)
      : L_(L), begin_(kSize * L.first_value[first]), end_(kSize * L.first_value[last + 1]) {}
  void before_forward(int s) {
    const std::int64_t wanted = std::min(end_, kSize * L_.first_value[s + 1] + kAhead);
    if (wanted - begin_ < kAhead / 2 && wanted < end_) return;
    L_.values->will_need(begin_, wanted - begin_);
    begin_ = wanted;
  }
  void before_backward(int s) {
    const std::int64_t wanted = std::max(begin_, kSize * L_.first_value[s] - kAhead);
    if (end_ - wanted < kAhead / 2 && wanted > begin_) return;
    L_.values->will_need(wanted, end_ - wanted);
    end_ = wanted;
  }

 private:
  static constexpr auto kSize = static_cast<std::int64_t>(sizeof(Real));
  static constexpr std::int64_t kAhead = 64'000'000;
  const Arrays& L_;
  std::int64_t begin_, end_;
};

// Forwards through a subtree; `above` collects what it adds to the rows above its root.
template <int W, class Real>
FLEXURA_INLINE void forward_subtree(const Arrays& L, int root, const Panels<W>& X, const Panels<W>& v,
                                    const Panels<W>& above) {
  const int first = L.plan->first_descendant[root], end = L.first_column[root + 1];
  Ahead<Real> ahead(L, first, root);
  for (int s = first; s <= root; ++s) {
    ahead.before_forward(s);
    begin_forward(L, s, X, v);
    for (int b = 0; b < n_blocks(L, s); ++b) {
      const Block<Real> block = block_of<Real>(L, s, b);
      forward_triangle(block, v);
      forward_rows(block, 0, block.height - block.count, v);
    }
    store_own(L, s, X, v);
    const int *below = L.rows_below(s), *place = L.plan->place.data() + (below - L.rows);
    for (int p = 0; p < X.count; ++p) {
      const typename Panels<W>::Row* from = v[p] + L.width(s);
      std::ptrdiff_t r = 0;
      for (; r < L.n_below(s) && below[r] < end; ++r) X[p][below[r]] += from[r];
      for (; r < L.n_below(s); ++r) above[p][place[r]] += from[r];
    }
  }
}

template <int W, class Real>
FLEXURA_INLINE void backward_subtree(const Arrays& L, int root, const Panels<W>& X, const Panels<W>& v) {
  const int first = L.plan->first_descendant[root];
  Ahead<Real> ahead(L, first, root);
  for (int s = root; s >= first; --s) {
    ahead.before_backward(s);
    begin_backward(L, s, X, v);
    for (int b = n_blocks(L, s) - 1; b >= 0; --b) {
      const Block<Real> block = block_of<Real>(L, s, b);
      backward_rows(block, 0, block.height - block.count, v, {v.first + block.first, v.rows, v.count});
      backward_triangle(block, v);
    }
    store_own(L, s, X, v);
  }
}

// Calls work(share, begin, end) for shares of n rows, on all cores where there is enough to do.
template <class Work>
int share_rows(std::ptrdiff_t n, std::ptrdiff_t numbers, const Work& work) {
  const int shares = numbers < 100'000 ? 1 : n_cores();
  parallel_for(shares, [&](int k) { work(k, n * k / shares, n * (k + 1) / shares); });
  return shares;
}

// A supernode above the subtrees.
template <int W, class Real>
void forward_top(const Arrays& L, int s, const Panels<W>& X, const Panels<W>& v) {
  begin_forward(L, s, X, v);
  for (int b = 0; b < n_blocks(L, s); ++b) {
    const Block<Real> block = block_of<Real>(L, s, b);
    on_wide_registers([&]() __attribute__((always_inline)) { forward_triangle(block, v); });
    const std::ptrdiff_t n = block.height - block.count;
    share_rows(n, n * block.count * v.count, [&](int, std::ptrdiff_t begin, std::ptrdiff_t end) {
      on_wide_registers([&]() __attribute__((always_inline)) { forward_rows(block, begin, end, v); });
    });
  }
  store_own(L, s, X, v);
  const int* below = L.rows_below(s);
  for (int p = 0; p < X.count; ++p)
    for (std::ptrdiff_t r = 0; r < L.n_below(s); ++r) X[p][below[r]] += v[p][L.width(s) + r];
}

template <int W, class Real>
void backward_top(const Arrays& L, int s, const Panels<W>& X, const Panels<W>& v) {
  begin_backward(L, s, X, v);
  OwnPanels<W> sums(Trapezoid::kBlock, v.count * n_cores());  // of each share
  for (int b = n_blocks(L, s) - 1; b >= 0; --b) {
    const Block<Real> block = block_of<Real>(L, s, b);
    sums.set_zero();
    const Panels<W> sum = sums.get();
    const auto of_share = [&](int share) { return Panels<W>{sum[share * v.count], sum.rows, v.count}; };
    const std::ptrdiff_t n = block.height - block.count;
    const int shares =
        share_rows(n, n * block.count * v.count, [&](int share, std::ptrdiff_t begin, std::ptrdiff_t end) {
          const Panels<W> x = of_share(share);
          on_wide_registers([&]() __attribute__((always_inline)) { backward_rows(block, begin, end, v, x); });
        });
    for (int share = 0; share < shares; ++share)
      for (int p = 0; p < v.count; ++p)
        for (std::ptrdiff_t c = 0; c < block.count; ++c) v[p][block.first + c] += of_share(share)[p][c];
    on_wide_registers([&]() __attribute__((always_inline)) { backward_triangle(block, v); });
  }
  store_own(L, s, X, v);
}

// X = (L S L^T)^-1 X.
template <int W, class Real>
void solve_panels(const Arrays& L, const Panels<W>& X) {
  const std::vector<int>&roots = L.plan->subtrees.roots, &top = L.plan->subtrees.top;
  const int n_roots = static_cast<int>(roots.size());
  std::vector<OwnPanels<W>> above;
  for (const int root : roots) above.emplace_back(L.n_below(root), X.count);
  parallel_for(n_roots, [&](int k) {
    const OwnPanels<W> v(L.plan->longest[k], X.count);
    above[k].set_zero();
    on_wide_registers([&]() __attribute__((always_inline)) {
      forward_subtree<W, Real>(L, roots[k], X, v.get(), above[k].get());
    });
  });
  for (int k = 0; k < n_roots; ++k) {
    const Panels<W> sum = above[k].get();
    const int* below = L.rows_below(roots[k]);
    for (int p = 0; p < X.count; ++p)
      for (std::ptrdiff_t r = 0; r < sum.rows; ++r) X[p][below[r]] += sum[p][r];
  }
  {
    std::ptrdiff_t longest = 0;
    for (const int s : top) longest = std::max<std::ptrdiff_t>(longest, L.height(s));
    const OwnPanels<W> v(longest, X.count);
    for (const int s : top) {
      Ahead<Real>(L, s, s).before_forward(s);
      forward_top<W, Real>(L, s, X, v.get());
    }
    for (auto s = top.rbegin(); s != top.rend(); ++s) {
      Ahead<Real>(L, *s, *s).before_backward(*s);
      backward_top<W, Real>(L, *s, X, v.get());
    }
  }
  parallel_for(n_roots, [&](int k) {
    const OwnPanels<W> v(L.plan->longest[k], X.count);
    on_wide_registers([&]() __attribute__((always_inline)) {
      backward_subtree<W, Real>(L, roots[k], X, v.get());
    });
  });
}

template <int W>
void solve_columns(const Arrays& L, bool single, const Eigen::Ref<const Eigen::MatrixXd>& B,
                   Eigen::Index first, Eigen::Index count, Eigen::Ref<Eigen::MatrixXd>& X) {
  const OwnPanels<W> own(L.n, static_cast<int>((count + W - 1) / W));
  const Panels<W> panels = own.get();
  double* numbers = reinterpret_cast<double*>(panels.first);
  const auto place = [&](Eigen::Index k, Eigen::Index c) -> double& {
    return numbers[(c / W * L.n + k) * W + c % W];
  };
  share_rows(L.n, L.n * count, [&](int, std::ptrdiff_t begin, std::ptrdiff_t end) {
    for (std::ptrdiff_t k = begin; k < end; ++k)
      for (Eigen::Index c = 0; c < panels.count * W; ++c)
        place(k, c) = c < count ? B(L.order[k], first + c) : 0.0;
  });
  if (single)
    solve_panels<W, float>(L, panels);
  else
    solve_panels<W, double>(L, panels);
  share_rows(L.n, L.n * count, [&](int, std::ptrdiff_t begin, std::ptrdiff_t end) {
    for (std::ptrdiff_t k = begin; k < end; ++k)
      for (Eigen::Index c = 0; c < count; ++c) X(L.order[k], first + c) = place(k, c);
  });
}

}  // namespace

void SupernodalFactor::solve(const Eigen::Ref<const Eigen::MatrixXd>& B, Eigen::MatrixXd& X) const {
  X.resize(B.rows(), B.cols());
  solve_into(B, X);
}

void SupernodalFactor::solve_into(const Eigen::Ref<const Eigen::MatrixXd>& B,
                                  Eigen::Ref<Eigen::MatrixXd> X) const {
  if (n_ == 0) return;
  const Arrays L{n_,           n_supernodes(), first_column_.data(), first_row_.data(),
                 rows_.data(), order_.data(),  first_value_.data(),  signs_.data(),
                 &values_,     &plan_};
  constexpr Eigen::Index kTogether = 16;  // what the caches hold beside L
  for (Eigen::Index first = 0; first < B.cols(); first += kTogether) {
    const Eigen::Index count = std::min(kTogether, B.cols() - first);
    if (count > 4)
      solve_columns<8>(L, single_, B, first, count, X);
    else if (count > 1)
      solve_columns<4>(L, single_, B, first, count, X);
    else
      solve_columns<1>(L, single_, B, first, count, X);
  }
}

}  // namespace flexura::linalg
