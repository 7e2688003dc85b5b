// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

namespace flexura::view {

/// Rows 0, k, 2 k, ... and the last one, with the least k that leaves at most about `most` of them.
inline std::vector<Eigen::Index> thin(Eigen::Index rows, double most) {
  const auto step =
      static_cast<Eigen::Index>(std::max(1.0, std::ceil(static_cast<double>(rows) / std::max(2.0, most))));
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < rows; i += step) kept.push_back(i);
  if (rows > 0 && kept.back() != rows - 1) kept.push_back(rows - 1);
  return kept;
}

}  // namespace flexura::view
