// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>

namespace flexura::linalg {

/// How columns 0 ... width - 1 of the lower triangle of a matrix with `height` rows lie in memory: by blocks
/// of kBlock columns, each a dense matrix by columns that begins at its first diagonal entry.  So what lies
/// above the diagonal is stored within the blocks only, and products see long columns all the same.
struct Trapezoid {
  static constexpr std::ptrdiff_t kBlock = 240;  // ten leaves of the recursion in columns, forty solve panels

  std::ptrdiff_t height = 0, width = 0;

  int n_blocks() const { return static_cast<int>((width + kBlock - 1) / kBlock); }
  static std::ptrdiff_t first(int b) { return b * kBlock; }  ///< column (and row) of a block
  std::ptrdiff_t count(int b) const { return std::min(kBlock, width - first(b)); }  ///< its columns
  std::ptrdiff_t stride(int b) const { return height - first(b); }                  ///< its rows
  std::ptrdiff_t offset(int b) const {                                              ///< where it begins
    const std::ptrdiff_t n = b;
    return kBlock * (n * height - kBlock * (n * (n - 1) / 2));
  }
  std::ptrdiff_t size() const {  ///< of all
    const int last = n_blocks() - 1;
    return last < 0 ? 0 : offset(last) + count(last) * stride(last);
  }
  /// The place of entry (c, c); the column goes on from there.
  std::ptrdiff_t diagonal(std::ptrdiff_t c) const {
    const auto b = static_cast<int>(c / kBlock);
    return offset(b) + (c - first(b)) * (stride(b) + 1);
  }
};

}  // namespace flexura::linalg
