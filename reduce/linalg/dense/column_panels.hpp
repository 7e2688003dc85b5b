// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <type_traits>

#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::linalg {

/// Calls work(W, first, count) for panels of `count` columns from `first` on, one panel per core at a time.
/// W is the panel's width as an integral constant: eight numbers fill the registers, few columns take less.
template <class Work>
void for_each_panel(Eigen::Index n_cols, const Work& work) {
  const auto run = [&](auto width) {
    parallel_for(static_cast<int>((n_cols + width - 1) / width), [&](int p) {
      const Eigen::Index first = static_cast<Eigen::Index>(p) * width;
      work(width, first, std::min<Eigen::Index>(width, n_cols - first));
    });
  };
  if (n_cols > 8)
    run(std::integral_constant<int, 8>());
  else if (n_cols > 1)
    run(std::integral_constant<int, 4>());
  else
    run(std::integral_constant<int, 1>());
}

}  // namespace flexura::linalg
