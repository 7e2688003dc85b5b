// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/base/math/simd.hpp"

/// Products with the small dense matrices of cells, in single precision on the machine's widest registers.
namespace flexura::linalg {

/// Eight numbers that lie together.
typedef float Eight __attribute__((vector_size(32), aligned(4), may_alias));

/// Y = A X; A m x n by rows, m a multiple of three, X n x 16 and Y m x 16 by rows.
inline void multiply_sixteen(const float* A, int m, int n, const float* X, float* Y) {
  on_this_machine([&]() __attribute__((always_inline)) {
    for (int i = 0; i < m; i += 3) {
      Eight y00{}, y01{}, y10{}, y11{}, y20{}, y21{};
      const float *a0 = A + static_cast<long>(i) * n, *a1 = a0 + n, *a2 = a1 + n;
      for (int j = 0; j < n; ++j) {
        const Eight* x = reinterpret_cast<const Eight*>(X + 16 * j);
        y00 += a0[j] * x[0];
        y01 += a0[j] * x[1];
        y10 += a1[j] * x[0];
        y11 += a1[j] * x[1];
        y20 += a2[j] * x[0];
        y21 += a2[j] * x[1];
      }
      Eight* y = reinterpret_cast<Eight*>(Y + 16 * i);
      y[0] = y00;
      y[1] = y01;
      y[2] = y10;
      y[3] = y11;
      y[4] = y20;
      y[5] = y21;
    }
  });
}

}  // namespace flexura::linalg
