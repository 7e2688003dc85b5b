// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <string>

#include "mbs/base/math/spatial.hpp"
#include "mbs/superelement/superelement.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

namespace flexura::mbs::surfaces {

/// A straight beam whose surface is its two ends: squares of this side of n x n, which move with the interfaces "root" and "tip".
inline superelement::Superelement faced_bar(const beams::StraightBeam& beam, double side, int n) {
  superelement::Superelement se = beams::beam_superelement(beam);
  const int k = n + 1;
  se.surface.vertices.resize(2 * k * k, 3);
  se.surface.triangles.resize(4 * n * n, 3);
  se.shapes.resize(6 * k * k, se.n());
  int t = 0;
  for (int end = 0; end < 2; ++end) {
    int index = 0;
    while (se.interfaces[static_cast<std::size_t>(index)].name != (end == 0 ? "root" : "tip")) ++index;
    const superelement::Interface& interface = se.interfaces[static_cast<std::size_t>(index)];
    const Eigen::MatrixXd motion = superelement::interface_motion(se, interface);
    const int first = end * k * k;
    for (int i = 0; i < k; ++i)
      for (int j = 0; j < k; ++j) {
        const Vector3d r(0.0, side * (static_cast<double>(i) / n - 0.5),
                         side * (static_cast<double>(j) / n - 0.5));
        const int v = first + i * k + j;
        se.surface.vertices.row(v) = (interface.p_BoN_B + r).transpose();
        se.shapes.middleRows(3 * v, 3) =
            (motion.topRows<3>() - skew(r) * motion.bottomRows<3>()).cast<float>();
      }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        // y x z = x: outside at the tip.
        const int p = first + i * k + j, q = p + k;
        const int out = end == 0 ? p + 1 : q, in = end == 0 ? q : p + 1;
        se.surface.triangles.row(t++) << p, out, in;
        se.surface.triangles.row(t++) << q + 1, in, out;
        for (int half = 0; half < 2; ++half) se.surface.triangle_interface.push_back(index);
      }
  }
  return se;
}

}  // namespace flexura::mbs::surfaces
