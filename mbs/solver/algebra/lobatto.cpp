// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/lobatto.hpp"

namespace flexura::mbs::lobatto {

double basis(int i, double x) {
  double value = 1.0;
  for (int j = 0; j < 4; ++j)
    if (j != i) value *= (x - kNode[j]) / (kNode[i] - kNode[j]);
  return value;
}

double integral_of_basis(int i, double x) {
  // The other three nodes: (u - a)(u - b)(u - c) = u^3 - S u^2 + P u - Q.
  double a[3], scale = 1.0;
  for (int j = 0, k = 0; j < 4; ++j)
    if (j != i) {
      a[k++] = kNode[j];
      scale *= kNode[i] - kNode[j];
    }
  const double S = a[0] + a[1] + a[2], P = a[0] * a[1] + a[1] * a[2] + a[2] * a[0], Q = a[0] * a[1] * a[2];
  return x * (x * (x * (0.25 * x - S / 3.0) + 0.5 * P) - Q) / scale;
}

}  // namespace flexura::mbs::lobatto
