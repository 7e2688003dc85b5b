// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <vector>

#include "mbs/base/math/spatial.hpp"
#include "mbs/superelement/superelement.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

namespace flexura::mbs::surfaces {

/// A straight beam with a ribbon of this width for its surface: two vertices at each interface.
inline superelement::Superelement ribbon(const beams::StraightBeam& beam, double width) {
  superelement::Superelement se = beams::beam_superelement(beam);
  std::vector<const superelement::Interface*> along;
  for (const superelement::Interface& i : se.interfaces) along.push_back(&i);
  std::ranges::sort(along, {}, [](const auto* i) { return i->p_BoN_B.x(); });
  const auto n = static_cast<int>(along.size());
  se.surface.vertices.resize(2 * n, 3);
  se.shapes.resize(6 * n, se.n());
  for (int i = 0; i < n; ++i)
    for (int side = 0; side < 2; ++side) {
      const superelement::Interface& at = *along[static_cast<std::size_t>(i)];
      const Vector3d r(0.0, (side - 0.5) * width, 0.0);
      se.surface.vertices.row(2 * i + side) = (at.p_BoN_B + r).transpose();
      const Eigen::MatrixXd motion = superelement::interface_motion(se, at);
      se.shapes.middleRows(3 * (2 * i + side), 3) =
          (motion.topRows<3>() - skew(r) * motion.bottomRows<3>()).cast<float>();
    }
  se.surface.triangles.resize(2 * (n - 1), 3);
  for (int i = 0; i + 1 < n; ++i) {
    se.surface.triangles.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 1;
    se.surface.triangles.row(2 * i + 1) << 2 * i + 1, 2 * i + 2, 2 * i + 3;
  }
  se.surface.triangle_interface.assign(static_cast<std::size_t>(2 * (n - 1)), -1);
  return se;
}

}  // namespace flexura::mbs::surfaces
