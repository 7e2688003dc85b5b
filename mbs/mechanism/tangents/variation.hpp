// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/kinematics/kinematics.hpp"

/// Private to the sources of Mechanism: equation (1) of inertia_tangents.cpp.
namespace flexura::mbs {

/// How a frame M moves, all in W: turn and shift of its origin, changes of its twist and acceleration there.
struct Change {
  Vector3d dtheta = Vector3d::Zero(), dp = Vector3d::Zero(), dw, dv, dalpha, da;
};
/// How M changes with a coordinate of its motion relative to F and with that coordinate's speed: (w, u) is
/// the speed's twist, V_q and A_q the changes of the relative twist and acceleration with the coordinate at
/// resting axes, A_v those of the acceleration with the speed.
struct RelativeChange {
  Change by_q, by_v;

  RelativeChange(const Spatial& V_F, const Spatial& A_F, const Vector3d& w, const Vector3d& u,
                 const Spatial& V_q, const Spatial& A_q, const Spatial& A_v)
      : by_q{w, u, V_q.angular, V_F.angular.cross(u) + V_q.linear, {}, {}},
        by_v{Vector3d::Zero(), Vector3d::Zero(), w, u, {}, {}} {
    const Vector3d &w_F = V_F.angular, &alpha_F = A_F.angular;
    by_q.dalpha = w_F.cross(V_q.angular) + A_q.angular;
    by_q.da = alpha_F.cross(u) + w_F.cross(w_F.cross(u)) + 2.0 * w_F.cross(V_q.linear) + A_q.linear;
    by_v.dalpha = w_F.cross(w) + A_v.angular;
    by_v.da = 2.0 * w_F.cross(u) + A_v.linear;
  }
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
