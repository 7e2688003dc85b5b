// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/fronts.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "reduce/linalg/dense/blas_threads.hpp"
#include "reduce/linalg/dense/parallel.hpp"
#include "reduce/linalg/factor/front_columns.hpp"

namespace flexura::linalg {
namespace {

// Calls work(first, count) for shares of n: one, or several on all cores where there is enough to do.
template <class Work>
void share(std::ptrdiff_t n, std::ptrdiff_t numbers, bool on_all_cores, const Work& work) {
  if (!on_all_cores || numbers < 1'000'000) return work(std::ptrdiff_t{0}, n);
  const int shares = 4 * n_cores();
  parallel_for(shares, [&](int k) {
    const std::ptrdiff_t first = n * k / shares;
    work(first, n * (k + 1) / shares - first);
  });
}

}  // namespace

template <class Real>
Fronts<Real>::Fronts(const UpperCsr& A, SupernodalFactor& L, bool must_be_definite)
    : A_(A),
      L_(L),
      must_be_definite_(must_be_definite),
      tree_(supernode_tree(L.first_column_, L.first_row_, L.rows_)),
      updates_(L.n_supernodes()),
      owned_(L.n_supernodes()) {
  std::vector<double> work(L.n_supernodes());
  for (int s = 0; s < L.n_supernodes(); ++s) {
    const double w = L.width(s), h = L.height(s);
    work[s] = w * h * h;
  }
  subtrees_ = divide(tree_, std::move(work), n_cores());
}

template <class Real>
int Fronts<Real>::run() {
  const OneBlasThread one;
  // The threads keep their work space: the first time decides.
  static const bool has_room = (require_blas_memory(n_cores()), true);
  static_cast<void>(has_room);
  permute();
  const std::size_t stack = room();
  parallel_for(static_cast<int>(subtrees_.roots.size()), [&](int k) {
    Scratch scratch = take_scratch(stack);
    process_subtree(subtrees_.roots[k], scratch);
    give_back(std::move(scratch));
  });
  spare_.clear();
  std::vector<int> place(L_.n_);
  for (const int s : subtrees_.top) {
    owned_[s].reset(new Real[n_updates(s)]);
    process(s, true, place, owned_[s].get());
  }
  const int failed = failed_;
  return failed == kNone ? -1 : failed;
}

template <class Real>
double Fronts<Real>::peak_bytes() const {
  // Subtrees: each core its stack; the roots' updates wait.  Numbers of L come as they are written.
  double numbers = static_cast<double>(n_cores()) * static_cast<double>(room()), most = 0.0;
  for (const int root : subtrees_.roots) {
    for (int s = tree_.first_descendant[root]; s <= root; ++s)
      numbers += static_cast<double>(L_.first_value_[s + 1] - L_.first_value_[s]);
    numbers += static_cast<double>(n_updates(root));
  }
  most = numbers;
  numbers -= static_cast<double>(n_cores()) * static_cast<double>(room());
  for (const int s : subtrees_.top) {
    numbers +=
        static_cast<double>(L_.first_value_[s + 1] - L_.first_value_[s]) + static_cast<double>(n_updates(s));
    most = std::max(most, numbers);
    numbers -= static_cast<double>(n_updates_of_children(s));
  }
  return sizeof(Real) * most;
}

template <class Real>
std::size_t Fronts<Real>::n_updates(int s) const {
  const std::ptrdiff_t below = L_.height(s) - L_.width(s);
  return static_cast<std::size_t>(Trapezoid{below, below}.size());
}

template <class Real>
std::size_t Fronts<Real>::n_updates_of_children(int s) const {
  std::size_t sum = 0;
  for (const int child : tree_.children[s]) sum += n_updates(child);
  return sum;
}

template <class Real>
typename Fronts<Real>::Scratch Fronts<Real>::take_scratch(std::size_t room) {
  const std::scoped_lock lock(mutex_);
  if (spare_.empty()) return {std::vector<int>(L_.n_), std::unique_ptr<Real[]>(new Real[room])};
  Scratch scratch = std::move(spare_.back());
  spare_.pop_back();
  return scratch;
}

template <class Real>
void Fronts<Real>::give_back(Scratch scratch) {
  const std::scoped_lock lock(mutex_);
  spare_.push_back(std::move(scratch));
}

// Updates of a subtree in postorder: a parent's is made above those of its children, which are the last on
// the stack, and then moved down to their place.
template <class Real>
std::size_t Fronts<Real>::stack_size(int root) const {
  std::size_t height = 0, greatest = 0;
  for (int s = tree_.first_descendant[root]; s <= root; ++s) {
    greatest = std::max(greatest, height + n_updates(s));
    height += n_updates(s) - n_updates_of_children(s);
  }
  return greatest;
}

template <class Real>
std::size_t Fronts<Real>::room() const {
  std::size_t room = 0;
  for (const int root : subtrees_.roots) room = std::max(room, stack_size(root));
  return room;
}

template <class Real>
void Fronts<Real>::process_subtree(int root, Scratch& scratch) {
  std::size_t height = 0;
  for (int s = tree_.first_descendant[root]; s <= root; ++s) {
    Real* made = scratch.stack.get() + height;
    process(s, false, scratch.place, made);
    height -= n_updates_of_children(s);
    updates_[s] = scratch.stack.get() + height;
    std::copy_n(made, n_updates(s), scratch.stack.get() + height);
    height += n_updates(s);
  }
  owned_[root].reset(new Real[n_updates(root)]);
  std::copy_n(updates_[root], n_updates(root), owned_[root].get());
  updates_[root] = owned_[root].get();
}

template <class Real>
void Fronts<Real>::permute() {
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

// The columns of supernode s, and what they leave to the rows below: U.
template <class Real>
void Fronts<Real>::process(int s, bool on_all_cores, std::vector<int>& place, Real* U) {
  if (failed_ != kNone) return;
  const Trapezoid shape = L_.shape(s);
  const int* rows = L_.rows_.data() + L_.first_row_[s];
  Real* F = L_.template values<Real>() + L_.first_value_[s];
  for (std::ptrdiff_t r = 0; r < shape.height; ++r) place[rows[r]] = static_cast<int>(r);
  updates_[s] = U;
  const auto n_U = static_cast<std::ptrdiff_t>(n_updates(s));
  share(shape.size(), shape.size(), on_all_cores,
        [&](std::ptrdiff_t first, std::ptrdiff_t count) { std::fill_n(F + first, count, Real(0)); });
  share(n_U, n_U, on_all_cores,
        [&](std::ptrdiff_t first, std::ptrdiff_t count) { std::fill_n(U + first, count, Real(0)); });
  for (std::ptrdiff_t c = 0; c < shape.width; ++c) {
    Real* column = F + shape.diagonal(c) - c;
    const std::ptrdiff_t column_of_L = L_.first_column_[s] + c;
    for (int k = begin_[column_of_L]; k < begin_[column_of_L + 1]; ++k)
      column[place[row_[k]]] += static_cast<Real>(entry_[k]);
  }
  for (const int child : tree_.children[s]) {
    add_update(child, place, shape, F, U, on_all_cores);
    owned_[child].reset();  // others lie on the stack of the subtree
  }
  const std::ptrdiff_t failed =
      factorise_front(shape, F, U, L_.signs_.data() + L_.first_column_[s], must_be_definite_, on_all_cores);
  for (std::ptrdiff_t c = 0; c < shape.width; ++c)
    L_.diagonal_[L_.first_column_[s] + c] = F[shape.diagonal(c)];
  if (failed < 0) return;
  int none = kNone;
  failed_.compare_exchange_strong(none, L_.first_column_[s] + static_cast<int>(failed));
}

// What a child's front has left, into the parent's columns F and its own remainder U.
template <class Real>
void Fronts<Real>::add_update(int child, const std::vector<int>& place, const Trapezoid& shape, Real* F,
                              Real* U, bool on_all_cores) const {
  const std::ptrdiff_t n = L_.height(child) - L_.width(child), below = shape.height - shape.width;
  const Trapezoid from{n, n}, rest{below, below};
  const int* rows = L_.rows_.data() + L_.first_row_[child] + L_.width(child);
  std::vector<int> to(n);
  for (std::ptrdiff_t r = 0; r < n; ++r) to[r] = place[rows[r]];
  share(n, n * n, on_all_cores, [&](std::ptrdiff_t first, std::ptrdiff_t count) {
    for (std::ptrdiff_t c = first; c < first + count; ++c) {
      const Real* update = updates_[child] + from.diagonal(c) - c;
      Real* column = to[c] < shape.width ? F + shape.diagonal(to[c]) : U + rest.diagonal(to[c] - shape.width);
      column -= to[c];
      for (std::ptrdiff_t r = c; r < n; ++r) column[to[r]] += update[r];
    }
  });
}

template class Fronts<double>;
template class Fronts<float>;

}  // namespace flexura::linalg
