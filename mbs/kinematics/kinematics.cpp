// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/kinematics/kinematics.hpp"

namespace flexura::mbs {

Pose Kinematics::relative_pose(int marker_F, int marker_M) const {
  const Pose& F = markers[marker_F].X_WP;
  const Pose& M = markers[marker_M].X_WP;
  return {F.R.transpose() * M.R, F.R.transpose() * (M.p - F.p)};
}

Relative Kinematics::relative_motion(int marker_F, int marker_M) const {
  const MarkerState& F = markers[marker_F];
  const MarkerState& M = markers[marker_M];
  const Vector3d r = M.X_WP.p - F.X_WP.p;
  Relative rel;
  rel.X_FM = relative_pose(marker_F, marker_M);
  rel.V.head<3>() = F.X_WP.R.transpose() * (M.V.angular - F.V.angular);
  rel.V.tail<3>() = F.X_WP.R.transpose() * (M.V.linear - F.V.linear - F.V.angular.cross(r));
  return rel;
}

Relative Kinematics::relative_acceleration(int marker_F, int marker_M) const {
  const MarkerState& F = markers[marker_F];
  const MarkerState& M = markers[marker_M];
  Relative rel = relative_motion(marker_F, marker_M);
  const Vector3d r = M.X_WP.p - F.X_WP.p;
  const Vector3d& w = F.V.angular;
  const Vector3d u = M.V.linear - F.V.linear - w.cross(r);
  // Derivatives taken in F: those of the components.
  rel.A.head<3>() = F.X_WP.R.transpose() * (M.A.angular - F.A.angular - w.cross(M.V.angular));
  rel.A.tail<3>() = F.X_WP.R.transpose() *
                    (M.A.linear - F.A.linear - F.A.angular.cross(r) - w.cross(w.cross(r)) - 2.0 * w.cross(u));
  return rel;
}

double Kinematics::coordinate(CoordinateRef of) const {
  const JointPlace& place = (*joints)[of.joint];
  if (place.in_tree()) return p[place.i_p + of.index];
  double q[7];
  place.joint->coordinates_of(relative_pose(place.marker_F, place.marker_M), q);
  return q[of.index];
}

double Kinematics::speed(CoordinateRef of) const {
  const JointPlace& place = (*joints)[of.joint];
  if (place.in_tree()) return v[place.i_v + of.index];
  const Relative rel = relative_motion(place.marker_F, place.marker_M);
  double q[7], w[6];
  place.joint->coordinates_of(rel.X_FM, q);
  place.joint->speeds_of(q, rel.V, w);
  return w[of.index];
}

double Kinematics::acceleration(CoordinateRef of) const {
  const JointPlace& place = (*joints)[of.joint];
  if (place.in_tree()) return v_dot[place.i_v + of.index];
  const Relative rel = relative_acceleration(place.marker_F, place.marker_M);
  double q[7], w[6];
  place.joint->coordinates_of(rel.X_FM, q);
  place.joint->speeds_of(q, rel.V, w);
  const Vector6d without_bias = rel.A - place.joint->bias(q, w);
  place.joint->speeds_of(q, without_bias, w);
  return w[of.index];
}

void Loads::apply_between(const Kinematics& kin, int marker_F, int marker_M, const Vector6d& on_M_F) {
  const Pose& F = kin.markers[marker_F].X_WP;
  const Spatial on_M = F.R * Spatial::from(on_M_F);
  apply(marker_M, on_M);
  const Spatial at_F = shift_wrench(on_M, kin.markers[marker_M].X_WP.p - F.p);
  apply(marker_F, Spatial{-at_F.angular, -at_F.linear});
}

}  // namespace flexura::mbs
