// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <vector>

#include "mbs/base/math/spatial.hpp"
#include "mbs/superelement/superelement.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

namespace flexura::mbs::surfaces {

/// Translations and rotations (6 x n) at xi l between two interfaces l apart along x: cubic in bending, linear else.
inline Eigen::MatrixXd motion_between(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double l,
                                      double xi) {
  const double H[] = {1 - xi * xi * (3 - 2 * xi), xi * (1 - xi) * (1 - xi) * l, xi * xi * (3 - 2 * xi),
                      xi * xi * (xi - 1) * l},
               D[] = {-6 * xi * (1 - xi) / l, (1 - xi) * (1 - 3 * xi), 6 * xi * (1 - xi) / l,
                      xi * (3 * xi - 2)};
  Eigen::MatrixXd out = (1 - xi) * a + xi * b;
  const auto bend = [&](const double* c, double sign, int place, int turn) -> Eigen::RowVectorXd {
    return c[0] * a.row(place) + sign * c[1] * a.row(turn) + c[2] * b.row(place) + sign * c[3] * b.row(turn);
  };
  out.row(1) = bend(H, 1.0, 1, 5);  // v' = theta_z, w' = -theta_y
  out.row(2) = bend(H, -1.0, 2, 4);
  out.row(4) = -bend(D, -1.0, 2, 4);
  out.row(5) = bend(D, 1.0, 1, 5);
  return out;
}

/// A straight beam with a ribbon of this width for its surface: two vertices at each interface, and at `parts` - 1 places between.
inline superelement::Superelement ribbon(const beams::StraightBeam& beam, double width, int parts = 1) {
  superelement::Superelement se = beams::beam_superelement(beam);
  std::vector<const superelement::Interface*> along;
  for (const superelement::Interface& i : se.interfaces) along.push_back(&i);
  std::ranges::sort(along, {}, [](const auto* i) { return i->p_BoN_B.x(); });
  const auto n = static_cast<int>(along.size() - 1) * parts + 1;
  se.surface.vertices.resize(2 * n, 3);
  se.shapes.resize(6 * n, se.n());
  for (int i = 0; i < n; ++i) {
    const int piece = std::min(i / parts, static_cast<int>(along.size()) - 2);
    const superelement::Interface &a = *along[static_cast<std::size_t>(piece)],
                                  &b = *along[static_cast<std::size_t>(piece + 1)];
    const double l = b.p_BoN_B.x() - a.p_BoN_B.x(), xi = static_cast<double>(i - piece * parts) / parts;
    const Eigen::MatrixXd motion =
        motion_between(superelement::interface_motion(se, a), superelement::interface_motion(se, b), l, xi);
    for (int side = 0; side < 2; ++side) {
      const Vector3d r(0.0, (side - 0.5) * width, 0.0);
      se.surface.vertices.row(2 * i + side) = (a.p_BoN_B + xi * l * Vector3d::UnitX() + r).transpose();
      se.shapes.middleRows(3 * (2 * i + side), 3) =
          (motion.topRows<3>() - skew(r) * motion.bottomRows<3>()).cast<float>();
    }
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
