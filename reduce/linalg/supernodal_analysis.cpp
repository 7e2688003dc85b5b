// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cholmod.h>

#include <numeric>
#include <stdexcept>
#include <string>

#include "reduce/linalg/supernodal_factor.hpp"

namespace flexura::linalg {
namespace {

struct Cholmod {
  cholmod_common common{};
  cholmod_factor* L = nullptr;

  Cholmod() {
    cholmod_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = 1;
  }
  ~Cholmod() {
    cholmod_free_factor(&L, &common);
    cholmod_finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  void check(const char* doing) const {
    if (common.status == CHOLMOD_OUT_OF_MEMORY)
      throw std::runtime_error(std::string("memory does not suffice while ") + doing +
                               ": use a coarser mesh or a machine with more memory");
    if (common.status == CHOLMOD_TOO_LARGE)
      throw std::runtime_error(std::string("the matrix is too large for 32-bit indices while ") + doing +
                               ": use a coarser mesh");
    if (common.status < 0)
      throw std::runtime_error(std::string("CHOLMOD failed while ") + doing + " (status " +
                               std::to_string(common.status) + ")");
  }
};

cholmod_sparse pattern_of(int n, std::span<const int> begin, std::span<const int> columns) {
  cholmod_sparse view{};
  view.nrow = view.ncol = static_cast<std::size_t>(n);
  view.nzmax = columns.size();
  view.p = const_cast<int*>(begin.data());
  view.i = const_cast<int*>(columns.data());
  view.stype = -1;  // upper triangle by rows = lower triangle by columns
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_PATTERN;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
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
  cholmod_sparse graph = pattern_of(n_groups, begin, columns);
  std::vector<int> group_order(n_groups), order;
  Cholmod cholmod;
  cholmod_metis(&graph, nullptr, 0, 1, group_order.data(), &cholmod.common);
  cholmod.check("ordering the matrix");
  order.reserve(A.n);
  for (const int g : group_order)
    for (int i = group_begin[g]; i < group_begin[g + 1]; ++i) order.push_back(i);
  return order;
}

SupernodalFactor::SupernodalFactor(const UpperCsr& A, std::vector<int> order)
    : n_(A.n), first_column_{0}, first_row_{0}, first_value_{0} {
  if (n_ == 0) return;
  if (static_cast<int>(order.size()) != n_)
    throw std::logic_error("the order does not have the matrix's length");
  Cholmod cholmod;
  cholmod_sparse pattern = pattern_of(A.n, A.row_begin, A.columns);
  cholmod.L = cholmod_analyze_p(&pattern, order.data(), nullptr, 0, &cholmod.common);
  cholmod.check("analysing the matrix");
  const cholmod_factor& L = *cholmod.L;
  const auto copy = [](const void* array, std::size_t count) {
    return std::vector<int>(static_cast<const int*>(array), static_cast<const int*>(array) + count);
  };
  first_column_ = copy(L.super, L.nsuper + 1);
  first_row_ = copy(L.pi, L.nsuper + 1);
  rows_ = copy(L.s, L.ssize);
  order_ = copy(L.Perm, L.n);
  for (int s = 0; s < n_supernodes(); ++s)
    first_value_.push_back(first_value_.back() + static_cast<std::int64_t>(width(s)) * height(s));
  nonzeros_ = cholmod.common.lnz;
  flops_ = cholmod.common.fl;
}

}  // namespace flexura::linalg
