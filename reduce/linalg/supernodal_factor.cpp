// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/supernodal_factor.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <queue>

#include "reduce/linalg/blas.hpp"
#include "reduce/linalg/blas_threads.hpp"
#include "reduce/linalg/parallel.hpp"

namespace flexura::linalg {
namespace {

// Calls work(first, count) for shares of n rows: one share, or several on all cores where the work of `flops`
// pays for threads.
template <class Work>
void share_rows(std::ptrdiff_t n, double flops, bool on_all_cores, const Work& work) {
  const int shares = on_all_cores && flops > 2e6 ? 2 * n_cores() : 1;
  if (shares == 1) return work(std::ptrdiff_t{0}, n);
  parallel_for(shares, [&](int k) {
    const std::ptrdiff_t first = n * k / shares;
    work(first, n * (k + 1) / shares - first);
  });
}

// C -= A B^T with A m x k, B n x k.
void subtract_product(std::ptrdiff_t m, std::ptrdiff_t n, std::ptrdiff_t k, const double* A,
                      std::ptrdiff_t lda, const double* B, std::ptrdiff_t ldb, double* C,
                      std::ptrdiff_t ldc) {
  if (m == 0 || n == 0 || k == 0) return;
  const int size[] = {static_cast<int>(m), static_cast<int>(n), static_cast<int>(k)};
  const int strides[] = {static_cast<int>(lda), static_cast<int>(ldb), static_cast<int>(ldc)};
  const double minus = -1.0, one = 1.0;
  dgemm_("N", "T", &size[0], &size[1], &size[2], &minus, A, &strides[0], B, &strides[1], &one, C,
         &strides[2]);
}

// B S, n x k with the signs of the columns; B itself where all are positive.
const double* with_signs(const double* B, std::ptrdiff_t& ldb, std::ptrdiff_t n, std::ptrdiff_t k,
                         const double* signs, std::vector<double>& copy) {
  if (std::all_of(signs, signs + k, [](double s) { return s > 0.0; })) return B;
  copy.resize(static_cast<std::size_t>(n * k));
  for (std::ptrdiff_t c = 0; c < k; ++c)
    for (std::ptrdiff_t i = 0; i < n; ++i) copy[c * n + i] = signs[c] * B[c * ldb + i];
  ldb = n;
  return copy.data();
}

constexpr int kNarrow = 24;  // columns that are factorised one by one

}  // namespace

/// One run of the multifrontal method.
class Fronts {
 public:
  Fronts(const UpperCsr& A, SupernodalFactor& L, bool must_be_definite)
      : A_(A),
        L_(L),
        must_be_definite_(must_be_definite),
        updates_(L.n_supernodes()),
        owned_(L.n_supernodes()) {
    permute();
    build_tree();
  }

  // The column of L at which the factorisation ended, or -1.
  int run() {
    const OneBlasThread one;
    std::vector<int> top, roots;
    divide(top, roots);
    std::size_t room = 0;
    for (const int root : roots) room = std::max(room, stack_size(root));
    parallel_for(static_cast<int>(roots.size()), [&](int k) {
      Scratch scratch = take_scratch(room);
      process_subtree(roots[k], scratch);
      give_back(std::move(scratch));
    });
    Scratch scratch = take_scratch(room);
    for (const int s : top) {
      owned_[s].reset(new double[n_updates(s)]);
      process(s, true, scratch.place, owned_[s].get());
      for (const int child : children_[s]) owned_[child].reset();
    }
    const int failed = failed_;
    return failed == kNone ? -1 : failed;
  }

 private:
  // What a thread works with.
  struct Scratch {
    std::vector<int> place;           // of a row of L in the front
    std::unique_ptr<double[]> stack;  // of updates that wait for their parent
  };

  std::size_t n_updates(int s) const {
    const auto below = static_cast<std::size_t>(L_.height(s) - L_.width(s));
    return below * below;
  }

  std::size_t n_updates_of_children(int s) const {
    std::size_t sum = 0;
    for (const int child : children_[s]) sum += n_updates(child);
    return sum;
  }

  Scratch take_scratch(std::size_t room) {
    const std::scoped_lock lock(mutex_);
    if (spare_.empty()) return {std::vector<int>(L_.n_), std::unique_ptr<double[]>(new double[room])};
    Scratch scratch = std::move(spare_.back());
    spare_.pop_back();
    return scratch;
  }

  void give_back(Scratch scratch) {
    const std::scoped_lock lock(mutex_);
    spare_.push_back(std::move(scratch));
  }

  // Updates of a subtree in postorder: a parent's is made above those of its children, which are the last on
  // the stack, and then moved down to their place.
  std::size_t stack_size(int root) const {
    std::size_t height = 0, greatest = 0;
    for (int s = first_descendant_[root]; s <= root; ++s) {
      greatest = std::max(greatest, height + n_updates(s));
      height += n_updates(s) - n_updates_of_children(s);
    }
    return greatest;
  }

  void process_subtree(int root, Scratch& scratch) {
    std::size_t height = 0;
    for (int s = first_descendant_[root]; s <= root; ++s) {
      double* made = scratch.stack.get() + height;
      process(s, false, scratch.place, made);
      height -= n_updates_of_children(s);
      updates_[s] = scratch.stack.get() + height;
      std::copy_n(made, n_updates(s), scratch.stack.get() + height);
      height += n_updates(s);
    }
    owned_[root].reset(new double[n_updates(root)]);
    std::copy_n(updates_[root], n_updates(root), owned_[root].get());
    updates_[root] = owned_[root].get();
  }

  // The lower triangle of P A P^T by columns.
  void permute() {
    std::vector<int> number(L_.n_);
    for (int k = 0; k < L_.n_; ++k) number[L_.order_[k]] = k;
    begin_.assign(L_.n_ + 1, 0);
    for (int i = 0; i < A_.n; ++i)
      for (int k = A_.row_begin[i]; k < A_.row_begin[i + 1]; ++k)
        ++begin_[std::min(number[i], number[A_.columns[k]]) + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    std::vector<int> place(begin_.begin(), begin_.end() - 1);
    entry_.resize(A_.columns.size());
    row_.resize(A_.columns.size());
    for (int i = 0; i < A_.n; ++i)
      for (int k = A_.row_begin[i]; k < A_.row_begin[i + 1]; ++k) {
        const auto [column, row] = std::minmax(number[i], number[A_.columns[k]]);
        const int at = place[column]++;
        row_[at] = row;
        entry_[at] = A_.values[k];
      }
  }

  // Supernodes are in postorder: the subtree of s is first_descendant_[s] ... s.
  void build_tree() {
    const int n = L_.n_supernodes();
    std::vector<int> supernode_of(L_.n_);
    for (int s = 0; s < n; ++s) std::fill_n(supernode_of.begin() + L_.first_column_[s], L_.width(s), s);
    children_.resize(n);
    first_descendant_.resize(n);
    work_.resize(n);
    std::iota(first_descendant_.begin(), first_descendant_.end(), 0);
    parent_.assign(n, -1);
    for (int s = 0; s < n; ++s) {
      const double w = L_.width(s), h = L_.height(s);
      work_[s] += w * h * h;
      if (L_.width(s) == L_.height(s)) continue;
      const int p = parent_[s] = supernode_of[L_.rows_[L_.first_row_[s] + L_.width(s)]];
      children_[p].push_back(s);
      first_descendant_[p] = std::min(first_descendant_[p], first_descendant_[s]);
      work_[p] += work_[s];
    }
  }

  // Roots of subtrees small enough to be shared out evenly, the largest first, and what is above them.
  void divide(std::vector<int>& top, std::vector<int>& roots) const {
    const auto smaller = [this](int a, int b) { return work_[a] < work_[b]; };
    std::priority_queue<int, std::vector<int>, decltype(smaller)> heap(smaller);
    double total = 0.0;
    for (int s = 0; s < L_.n_supernodes(); ++s)
      if (parent_[s] < 0) heap.push(s), total += work_[s];
    const double enough = n_cores() == 1 ? total : total / (6.0 * n_cores());
    while (!heap.empty() && work_[heap.top()] > enough) {
      const int s = heap.top();
      heap.pop();
      top.push_back(s);
      for (const int child : children_[s]) heap.push(child);
    }
    for (; !heap.empty(); heap.pop()) roots.push_back(heap.top());
    std::sort(top.begin(), top.end());
  }

  // The columns of supernode s, and what they leave to the rows below: U, its lower triangle.
  void process(int s, bool on_all_cores, std::vector<int>& place, double* U) {
    if (failed_ != kNone) return;
    const std::ptrdiff_t w = L_.width(s), h = L_.height(s), below = h - w;
    const int* rows = L_.rows_.data() + L_.first_row_[s];
    double* F = L_.values_.get() + L_.first_value_[s];
    double* signs = L_.signs_.data() + L_.first_column_[s];
    for (std::ptrdiff_t r = 0; r < h; ++r) place[rows[r]] = static_cast<int>(r);
    updates_[s] = U;
    share_rows(h, static_cast<double>(h) * h, on_all_cores, [&](std::ptrdiff_t first, std::ptrdiff_t count) {
      for (std::ptrdiff_t c = first; c < first + count; ++c) {
        if (c < w)
          std::fill_n(F + c * h, h, 0.0);
        else
          std::fill_n(U + (c - w) * (below + 1), h - c, 0.0);
      }
    });
    for (std::ptrdiff_t c = 0; c < w; ++c)
      for (int k = begin_[L_.first_column_[s] + c]; k < begin_[L_.first_column_[s] + c + 1]; ++k)
        F[c * h + place[row_[k]]] += entry_[k];
    for (const int child : children_[s]) add_update(child, place, w, h, F, U, on_all_cores);
    if (!factorise_columns(F, h, h, w, signs, on_all_cores, L_.first_column_[s])) return;
    // F_22 -= L_21 S L_21^T, the lower triangle by blocks of columns.
    std::vector<double> copy;
    std::ptrdiff_t ldb = h;
    const double* B = with_signs(F + w, ldb, below, w, signs, copy);
    constexpr std::ptrdiff_t kBlock = 192;
    const int n_blocks = static_cast<int>((below + kBlock - 1) / kBlock);
    const auto block = [&](int b) {
      const std::ptrdiff_t first = b * kBlock, count = std::min(kBlock, below - first);
      subtract_product(below - first, count, w, F + w + first, h, B + first, ldb, U + first * below + first,
                       below);
    };
    if (on_all_cores)
      parallel_for(n_blocks, block);
    else
      for (int b = 0; b < n_blocks; ++b) block(b);
  }

  // What a child's front has left, into the parent's columns F and its own remainder U.
  void add_update(int child, const std::vector<int>& place, std::ptrdiff_t w, std::ptrdiff_t h, double* F,
                  double* U, bool on_all_cores) {
    const std::ptrdiff_t n = L_.height(child) - L_.width(child), below = h - w;
    const int* rows = L_.rows_.data() + L_.first_row_[child] + L_.width(child);
    std::vector<int> to(n);
    for (std::ptrdiff_t r = 0; r < n; ++r) to[r] = place[rows[r]];
    const double* from = updates_[child];
    share_rows(n, static_cast<double>(n) * n, on_all_cores, [&](std::ptrdiff_t first, std::ptrdiff_t count) {
      for (std::ptrdiff_t c = first; c < first + count; ++c) {
        double* column = to[c] < w ? F + to[c] * h : U + (to[c] - w) * below - w;
        for (std::ptrdiff_t r = c; r < n; ++r) column[to[r]] += from[c * n + r];
      }
    });
  }

  // The first `width` columns of a trapezoid of `height` rows, by halves; `column` of L is the first.
  bool factorise_columns(double* F, std::ptrdiff_t ld, std::ptrdiff_t height, std::ptrdiff_t width,
                         double* signs, bool on_all_cores, int column) {
    if (width <= kNarrow) return factorise_narrow(F, ld, height, width, signs, on_all_cores, column);
    const std::ptrdiff_t left = (width / 2 + kNarrow - 1) / kNarrow * kNarrow, right = width - left;
    if (!factorise_columns(F, ld, height, left, signs, on_all_cores, column)) return false;
    std::vector<double> copy;
    std::ptrdiff_t ldb = ld;
    const double* B = with_signs(F + left, ldb, right, left, signs, copy);
    const std::ptrdiff_t rows = height - left;
    share_rows(rows, 2.0 * static_cast<double>(rows * right * left), on_all_cores,
               [&](std::ptrdiff_t first, std::ptrdiff_t count) {
                 subtract_product(count, right, left, F + left + first, ld, B, ldb,
                                  F + left * ld + left + first, ld);
               });
    return factorise_columns(F + left * ld + left, ld, rows, right, signs + left, on_all_cores,
                             column + static_cast<int>(left));
  }

  bool factorise_narrow(double* F, std::ptrdiff_t ld, std::ptrdiff_t height, std::ptrdiff_t width,
                        double* signs, bool on_all_cores, int column) {
    for (std::ptrdiff_t c = 0; c < width; ++c) {
      double* l = F + c * ld;
      const double d = l[c];
      if (!std::isfinite(d) || (must_be_definite_ ? !(d > 0.0) : d == 0.0)) {
        int none = kNone;
        failed_.compare_exchange_strong(none, column + static_cast<int>(c));
        return false;
      }
      signs[c] = d > 0.0 ? 1.0 : -1.0;
      l[c] = std::sqrt(std::abs(d));
      for (std::ptrdiff_t i = c + 1; i < width; ++i) l[i] *= signs[c] / l[c];
      for (std::ptrdiff_t j = c + 1; j < width; ++j)
        for (std::ptrdiff_t i = j; i < width; ++i) F[j * ld + i] -= signs[c] * l[j] * l[i];
    }
    // L_21 = A_21 L_11^-T S.
    const std::ptrdiff_t below = height - width;
    if (below == 0) return true;
    share_rows(below, static_cast<double>(below * width * width), on_all_cores,
               [&](std::ptrdiff_t first, std::ptrdiff_t count) {
                 const int m = static_cast<int>(count), n = static_cast<int>(width),
                           stride = static_cast<int>(ld);
                 const double one = 1.0;
                 double* B = F + width + first;
                 dtrsm_("R", "L", "T", "N", &m, &n, &one, F, &stride, B, &stride);
                 for (std::ptrdiff_t c = 0; c < width; ++c)
                   if (signs[c] < 0.0)
                     for (std::ptrdiff_t i = 0; i < count; ++i) B[c * ld + i] = -B[c * ld + i];
               });
    return true;
  }

  static constexpr int kNone = std::numeric_limits<int>::max();
  const UpperCsr& A_;
  SupernodalFactor& L_;
  bool must_be_definite_;
  std::vector<int> begin_, row_;
  std::vector<double> entry_;
  std::vector<int> parent_, first_descendant_;
  std::vector<std::vector<int>> children_;
  std::vector<double> work_;  // of the subtree
  std::vector<const double*> updates_;
  std::vector<std::unique_ptr<double[]>> owned_;  // updates from subtrees and at the top
  std::mutex mutex_;
  std::vector<Scratch> spare_;
  std::atomic<int> failed_{kNone};
};

int SupernodalFactor::factorise(const UpperCsr& A, bool must_be_definite) {
  if (A.n != n_) throw std::logic_error("factorise: the matrix is not the one that was analysed");
  if (n_ == 0) return -1;
  if (!values_) values_.reset(new double[static_cast<std::size_t>(first_value_.back())]);
  signs_.assign(n_, 1.0);
  const int column = Fronts(A, *this, must_be_definite).run();
  return column < 0 ? -1 : order_[column];
}

SupernodalFactor::Pivot SupernodalFactor::smallest_pivot(const UpperCsr& A) const {
  Pivot smallest;
  for (int s = 0; s < n_supernodes(); ++s)
    for (int c = 0; c < width(s); ++c) {
      const double l = values_[first_value_[s] + static_cast<std::int64_t>(c) * height(s) + c];
      const int row = order_[first_column_[s] + c];
      const double ratio = l * l / std::abs(A.values[A.row_begin[row]]);
      if (!(ratio >= smallest.ratio)) smallest = {ratio, row};
    }
  return smallest;
}

double SupernodalFactor::growth(const UpperCsr& A) const {
  std::vector<double> sums(n_, 0.0);
  for (int s = 0; s < n_supernodes(); ++s)
    for (int c = 0; c < width(s); ++c) {
      const double* column = values_.get() + first_value_[s] + static_cast<std::int64_t>(c) * height(s);
      for (int r = c; r < height(s); ++r) sums[rows_[first_row_[s] + r]] += column[r] * column[r];
    }
  double largest = 0.0;
  for (int k = 0; k < n_; ++k)
    largest = std::max(largest, sums[k] / std::abs(A.values[A.row_begin[order_[k]]]));
  return largest;
}

int SupernodalFactor::n_negative() const {
  return static_cast<int>(std::count_if(signs_.begin(), signs_.end(), [](double s) { return s < 0.0; }));
}

}  // namespace flexura::linalg
