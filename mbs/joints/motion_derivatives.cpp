// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/math/differences.hpp"
#include "mbs/joints/joint.hpp"

namespace flexura::mbs {

void Joint::motion_derivatives(const double* q, const double* v, MotionDerivatives& d) const {
  const int n = n_v();
  constexpr double h = kCentralStep;
  double moved[7], step[6] = {}, speeds[6];
  MotionMatrix S(6, n);
  d.bias_q.setZero(6, n);
  d.bias_v.setZero(6, n);
  for (int j = 0; j < n; ++j) {
    d.S_q[j].setZero(6, n);
    for (const double sign : {1.0, -1.0}) {
      step[j] = sign * h;
      retract(q, step, moved);
      S.setZero();
      motion(moved, S);
      d.S_q[j] += sign / (2.0 * h) * S;
      d.bias_q.col(j) += sign / (2.0 * h) * bias(moved, v);
      for (int i = 0; i < n; ++i) speeds[i] = v[i];
      // The bias is quadratic in v: any step is exact but for round-off.
      speeds[j] += sign;
      d.bias_v.col(j) += 0.5 * sign * bias(q, speeds);
    }
    step[j] = 0.0;
  }
}

}  // namespace flexura::mbs
