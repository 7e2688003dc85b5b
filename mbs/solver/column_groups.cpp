// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/column_groups.hpp"

namespace flexura::mbs {

void ColumnGroups::find(const Eigen::MatrixXd& pattern, const std::vector<bool>& skip) {
  groups_.clear();
  rows_.assign(pattern.cols(), {});
  std::vector<std::vector<bool>> taken;  // rows of each group
  for (Eigen::Index j = 0; j < pattern.cols(); ++j) {
    if (skip[j]) continue;
    for (Eigen::Index i = 0; i < pattern.rows(); ++i)
      if (pattern(i, j) != 0.0) rows_[j].push_back(static_cast<int>(i));
    std::size_t k = 0;
    const auto fits = [&] {
      for (const int i : rows_[j])
        if (taken[k][i]) return false;
      return true;
    };
    while (k < groups_.size() && !fits()) ++k;
    if (k == groups_.size()) {
      groups_.emplace_back();
      taken.emplace_back(pattern.rows(), false);
    }
    groups_[k].push_back(static_cast<int>(j));
    for (const int i : rows_[j]) taken[k][i] = true;
  }
}

}  // namespace flexura::mbs
