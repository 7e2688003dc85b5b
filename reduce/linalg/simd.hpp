// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/math/simd.hpp"

namespace flexura::linalg {

/// W numbers that lie together in an array of doubles, added and multiplied at once; the compiler takes the
/// widest registers it may.
template <int W>
struct Lanes {
  typedef double Row __attribute__((vector_size(8 * W), aligned(8), may_alias));
};
template <>
struct Lanes<1> {
  using Row = double;
};

}  // namespace flexura::linalg
