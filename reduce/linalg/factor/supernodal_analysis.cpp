// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cholmod.h>

#include <numeric>
#include <stdexcept>
#include <string>

#include "reduce/linalg/dense/parallel.hpp"
#include "reduce/linalg/factor/supernodal_factor.hpp"

namespace flexura::linalg {
namespace {

// What is called with 32-bit and what with 64-bit indices.
struct Narrow {
  using Index = int;
  static constexpr int kType = CHOLMOD_INT;
  static constexpr auto start = cholmod_start;
  static constexpr auto finish = cholmod_finish;
  static constexpr auto free_factor = cholmod_free_factor;
  static constexpr auto analyse = cholmod_analyze_p;
};
struct Wide {
  using Index = SuiteSparse_long;
  static constexpr int kType = CHOLMOD_LONG;
  static constexpr auto start = cholmod_l_start;
  static constexpr auto finish = cholmod_l_finish;
  static constexpr auto free_factor = cholmod_l_free_factor;
  static constexpr auto analyse = cholmod_l_analyze_p;
};

template <class Kind>
struct Cholmod {
  cholmod_common common{};
  cholmod_factor* L = nullptr;

  Cholmod() {
    Kind::start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = 1;
  }
  ~Cholmod() {
    Kind::free_factor(&L, &common);
    Kind::finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  void check(const char* doing) const {
    if (common.status == CHOLMOD_OUT_OF_MEMORY)
      throw std::runtime_error(std::string("memory does not suffice while ") + doing +
                               ": use a coarser mesh or a machine with more memory");
    if (common.status < 0)
      throw std::runtime_error(std::string("CHOLMOD failed while ") + doing + " (status " +
                               std::to_string(common.status) + ")");
  }
};

template <class Kind>
cholmod_sparse pattern_of(int n, std::span<const typename Kind::Index> begin,
                          std::span<const typename Kind::Index> columns) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(n);
  view.nzmax = columns.size();
  view.p = const_cast<typename Kind::Index*>(begin.data());
  view.i = const_cast<typename Kind::Index*>(columns.data());
  view.stype = -1;  // upper triangle by rows = lower triangle by columns
  view.itype = Kind::kType;
  view.xtype = CHOLMOD_PATTERN;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

// The same numbers, 64 bits wide where they are wanted so.
std::span<const int> widened(std::span<const int> numbers, std::vector<int>&) {
  return numbers;
}
std::span<const SuiteSparse_long> widened(std::span<const int> numbers, std::vector<SuiteSparse_long>& copy) {
  copy.assign(numbers.begin(), numbers.end());
  return copy;
}

struct Analysis {
  std::vector<int> first_column, first_row, rows, order;
  double nonzeros = 0.0, flops = 0.0;
};

// False where 32 bits do not count the factor's entries.
template <class Kind>
bool analyse(const UpperCsr& A, const std::vector<int>& order, Analysis& analysis) {
  using Index = typename Kind::Index;
  Cholmod<Kind> cholmod;
  {
    std::vector<Index> begin, columns, given;
    cholmod_sparse pattern = pattern_of<Kind>(A.n, widened(A.row_begin, begin), widened(A.columns, columns));
    cholmod.L = Kind::analyse(&pattern, const_cast<Index*>(widened(order, given).data()), nullptr, 0,
                              &cholmod.common);
  }
  if (cholmod.common.status == CHOLMOD_TOO_LARGE) return false;
  cholmod.check("analysing the matrix");
  const cholmod_factor& L = *cholmod.L;
  const auto copy = [](const void* array, std::size_t count) {
    return std::vector<int>(static_cast<const Index*>(array), static_cast<const Index*>(array) + count);
  };
  analysis = {copy(L.super, L.nsuper + 1), copy(L.pi, L.nsuper + 1), copy(L.s, L.ssize),
              copy(L.Perm, L.n),           cholmod.common.lnz,       cholmod.common.fl};
  return true;
}

}  // namespace

std::vector<int> nested_dissection(const UpperCsr& A, std::span<const int> group_begin) {
  std::vector<int> singles;
  if (group_begin.empty()) {
    singles.resize(A.n + 1);
    std::iota(singles.begin(), singles.end(), 0);
    group_begin = singles;
  }
  const int n_groups = static_cast<int>(group_begin.size()) - 1;
  std::vector<int> group_of(A.n), begin{0}, columns;
  for (int g = 0; g < n_groups; ++g)
    for (int i = group_begin[g]; i < group_begin[g + 1]; ++i) group_of[i] = g;
  for (int g = 0; g < n_groups; ++g) {
    const int i = group_begin[g];  // the first row of a group has the longest upper pattern
    int last = -1;
    if (group_begin[g] < group_begin[g + 1])
      for (int k = A.row_begin[i]; k < A.row_begin[i + 1]; ++k)
        if (group_of[A.columns[k]] != last) columns.push_back(last = group_of[A.columns[k]]);
    begin.push_back(static_cast<int>(columns.size()));
  }
  cholmod_sparse graph = pattern_of<Narrow>(n_groups, begin, columns);
  std::vector<int> group_order(n_groups), order;
  Cholmod<Narrow> cholmod;
  cholmod_metis(&graph, nullptr, 0, 1, group_order.data(), &cholmod.common);
  cholmod.check("ordering the matrix");
  order.reserve(A.n);
  for (const int g : group_order)
    for (int i = group_begin[g]; i < group_begin[g + 1]; ++i) order.push_back(i);
  return order;
}

SupernodalFactor::SupernodalFactor(const UpperCsr& A, std::vector<int> order, Indices indices)
    : n_(A.n), first_column_{0}, first_row_{0}, first_value_{0} {
  if (n_ == 0) return;
  if (static_cast<int>(order.size()) != n_)
    throw std::logic_error("the order does not have the matrix's length");
  Analysis analysis;
  if ((indices == Indices::wide || !analyse<Narrow>(A, order, analysis)) &&
      !analyse<Wide>(A, order, analysis))
    throw std::runtime_error("the factor has more entries than 64-bit indices can count: use a coarser mesh");
  first_column_ = std::move(analysis.first_column);
  first_row_ = std::move(analysis.first_row);
  rows_ = std::move(analysis.rows);
  order_ = std::move(analysis.order);
  nonzeros_ = analysis.nonzeros;
  flops_ = analysis.flops;
  for (int s = 0; s < n_supernodes(); ++s)
    first_value_.push_back(first_value_.back() + static_cast<std::int64_t>(shape(s).size()));
  plan_solves();
}

void SupernodalFactor::plan_solves() {
  SupernodeTree tree = supernode_tree(first_column_, first_row_, rows_);
  std::vector<double> work(n_supernodes());
  for (int s = 0; s < n_supernodes(); ++s) work[s] = static_cast<double>(shape(s).size());
  plan_ = {divide(tree, std::move(work), n_cores()), std::move(tree.first_descendant), {}, {}};
  plan_.place.resize(rows_.size());
  std::vector<int> place(n_);
  for (const int root : plan_.subtrees.roots) {
    for (int r = 0; r < height(root) - width(root); ++r) place[rows_[first_row_[root] + width(root) + r]] = r;
    std::ptrdiff_t longest = 0;
    for (int s = plan_.first_descendant[root]; s <= root; ++s) {
      longest = std::max<std::ptrdiff_t>(longest, height(s));
      for (int r = first_row_[s]; r < first_row_[s + 1]; ++r)
        if (rows_[r] >= first_column_[root + 1]) plan_.place[r] = place[rows_[r]];
    }
    plan_.longest.push_back(longest);
  }
}

}  // namespace flexura::linalg
