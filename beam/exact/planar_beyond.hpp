// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "beam/exact/planar_chain.hpp"

namespace flexura::beam::exact {

/// Sums over the mass beyond a section, about the start.
struct PlanarChain::Beyond {
  double m = 0.0, J = 0.0;  ///< int dm, int r.r dm and the sections' own about z
  Vec2 S, V;                ///< int r dm, int v dm
  double P = 0.0;           ///< int r.v dm
  double xx = 0.0, xy = 0.0, yy = 0.0;
  double vx = 0.0, vxy = 0.0, vyx = 0.0, vy = 0.0;  ///< int v_x x dm, v_x y, v_y x, v_y y

  void add(double dm, const Pass::Point& at, double I_z) {
    m += dm;
    J += dm * dot(at.r, at.r) + I_z;
    S += dm * at.r;
    xx += dm * at.r.x * at.r.x;
    xy += dm * at.r.x * at.r.y;
    yy += dm * at.r.y * at.r.y;
  }
  void add_motion(double dm, const Pass::Point& at) {
    V += dm * at.v;
    P += dm * dot(at.r, at.v);
    vx += dm * at.v.x * at.r.x;
    vxy += dm * at.v.x * at.r.y;
    vyx += dm * at.v.y * at.r.x;
    vy += dm * at.v.y * at.r.y;
  }
  /// int |r|^2 1 - r r^T dm.
  Matrix3d point_inertia() const {
    Matrix3d out = Matrix3d::Zero();
    out.topLeftCorner<2, 2>() << yy, -xy, -xy, xx;
    out(2, 2) = xx + yy;
    return out;
  }
};

}  // namespace flexura::beam::exact
