// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/error_weights.hpp"

namespace flexura::mbs {

ErrorWeights::ErrorWeights(const Equations& eq, const SolverOptions& options)
    : tolerance_(options.tolerance), floor_(options.absolute_factor) {
  const Sizes n = eq.sizes();
  position_scale_.resize(n.n_p);
  velocity_scale_.resize(n.n_v);
  for (int i = 0; i < n.n_p; ++i) position_scale_(i) = eq.position_scale(i);
  for (int i = 0; i < n.n_v; ++i) velocity_scale_(i) = eq.velocity_scale(i);
}

void ErrorWeights::evaluate(ConstVectorRef p, ConstVectorRef v, ConstVectorRef c, VectorRef w) const {
  w.head(p.size()).array() =
      1.0 / (tolerance_ * (p.array().abs().min(position_scale_.array()) + floor_ * position_scale_.array()));
  w.segment(p.size(), v.size()).array() =
      1.0 / (tolerance_ * (v.array().abs() + floor_ * velocity_scale_.array()));
  w.tail(c.size()).array() = 1.0 / (tolerance_ * (c.array().abs() + floor_));
}

}  // namespace flexura::mbs
