// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/model/kinematics.hpp"

/// Private to the sources of Mechanism: equation (1) of inertia_tangents.cpp.
namespace flexura::mbs {

/// How a frame M moves, all in W: turn and shift of its origin, changes of its twist and acceleration there.
struct Change {
  Vector3d dtheta = Vector3d::Zero(), dp = Vector3d::Zero(), dw, dv, dalpha, da;
};
/// phi, D and E about `origin`.
struct Variation {
  Spatial phi, D, E;
};
inline Variation variation(const MarkerState& M, const Vector3d& origin, const Change& d) {
  const Vector3d r = M.X_WP.p - origin;
  const Vector3d &w = M.V.angular, &v = M.V.linear;
  const Spatial V{w, v - w.cross(r)}, A{M.A.angular, M.A.linear - M.A.angular.cross(r) - w.cross(v)};
  const Spatial dV{d.dw, d.dv - d.dw.cross(r) - w.cross(d.dp)};
  const Spatial dA{d.dalpha,
                   d.da - d.dalpha.cross(r) - M.A.angular.cross(d.dp) - d.dw.cross(v) - w.cross(d.dv)};
  Variation out;
  out.phi = {d.dtheta, d.dp - d.dtheta.cross(r)};
  out.D = dV - cross_motion(out.phi, V);
  out.E = dA - cross_motion(out.phi, A) - cross_motion(out.D, V);
  return out;
}

}  // namespace flexura::mbs
