// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

namespace flexura::mbs {

/// tanh(|v| / v_0) / |v|, and its derivative by |v|.
struct Onset {
  double phi, slope;
  Onset(double speed, double v_0) {
    const double z = speed / v_0;
    if (z < 1e-4) {  // tanh z / z = 1 - z^2 / 3
      phi = (1.0 - z * z / 3.0) / v_0;
      slope = -2.0 / 3.0 * z / (v_0 * v_0);
      return;
    }
    const double step = std::tanh(z);
    phi = step / speed;
    slope = ((1.0 - step * step) / v_0 - phi) / speed;
  }
};

}  // namespace flexura::mbs
