// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/beam/ancf/exact/catenary.hpp"

#include <cmath>

namespace flexura::beam::exact {

Catenary::Catenary(double L_0, double W, double EA, double span) : L_0_(L_0), W_(W), EA_(EA) {
  // The span grows with H from almost nothing; bisection on a logarithmic scale to the last bit.
  double low = 1e-9 * W, high = W + EA;
  for (int i = 0; i < 200; ++i) {
    H_ = std::sqrt(low * high);
    (x(L_0) < span ? low : high) = H_;
  }
}

double Catenary::x(double s) const {
  return H_ * s / EA_ +
         H_ * L_0_ / W_ * (std::asinh(0.5 * W_ / H_) - std::asinh((0.5 * W_ - W_ * s / L_0_) / H_));
}

double Catenary::y(double s) const {
  const double V = 0.5 * W_, V_s = V - W_ * s / L_0_;
  return -W_ * s / EA_ * (0.5 - 0.5 * s / L_0_) -
         H_ * L_0_ / W_ * (std::sqrt(1 + V * V / (H_ * H_)) - std::sqrt(1 + V_s * V_s / (H_ * H_)));
}

}  // namespace flexura::beam::exact
