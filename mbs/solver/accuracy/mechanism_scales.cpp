// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/accuracy/mechanism_scales.hpp"

#include <algorithm>
#include <cmath>

namespace flexura::mbs {

namespace {

// The box around bodies and markers: of what moves, since ground may hold marks far away; of everything where
// what moves is a point; without any extent, the largest radius of gyration.
double length_of(const Mechanism& mechanism, const State& s, double& farthest) {
  const MechanismDescription& d = mechanism.description();
  std::vector<Pose> poses;
  mechanism.body_poses(s, *mechanism.make_scratch(), poses);
  for (const bool with_ground : {false, true}) {
    Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
    const auto take = [&](int body, const Vector3d& p_B) {
      if (body == 0 && !with_ground) return;
      const Pose& X = poses[static_cast<std::size_t>(body)];
      const Vector3d p = X.p + X.R * p_B;
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    };
    for (std::size_t b = 1; b < d.bodies.size(); ++b) {
      take(static_cast<int>(b), Vector3d::Zero());
      if (const FlexibleBody* deforms = mechanism.deforming(static_cast<int>(b)))
        for (const NodePlace& node : deforms->nodes()) take(static_cast<int>(b), node.p_BoN_B);
    }
    for (std::size_t i = 0; i < d.markers.size(); ++i)
      if (mechanism.modal_position(d.markers[i].body) < 0 || d.markers[i].node < 0)
        take(d.markers[i].body, d.undeformed(static_cast<int>(i)).p);
    if (!(low.x() <= high.x())) continue;
    farthest = std::max(high.cwiseAbs().maxCoeff(), low.cwiseAbs().maxCoeff());
    const double diagonal = (high - low).norm();
    if (std::isfinite(diagonal) && diagonal > 1e-9 * farthest) return diagonal;
  }
  double gyration = 0.0;
  for (const BodyDescription& body : d.bodies)
    if (body.inertia.mass > 0.0)
      gyration = std::max(gyration, std::sqrt(0.5 * body.inertia.inertia.trace() / body.inertia.mass));
  return gyration > 0.0 && std::isfinite(gyration) ? gyration : 1.0;
}

}  // namespace

Scales scales_of(const Mechanism& mechanism, const State& s) {
  const Sizes n = mechanism.sizes();
  Scales out;
  out.length = length_of(mechanism, s, out.farthest);
  // Modes, and whatever no joint of the tree says otherwise.
  out.reach_p.resize(n.n_p);
  out.reach_v.resize(n.n_v);
  for (int i = 0; i < n.n_p; ++i) out.reach_p(i) = 1.0 / mechanism.position_scale(i);
  for (int i = 0; i < n.n_v; ++i) out.reach_v(i) = 1.0 / mechanism.velocity_scale(i);
  for (const JointPlace& place : mechanism.joint_places()) {
    if (!place.in_tree()) continue;
    const auto coordinates = place.joint->coordinates(), speeds = place.joint->speeds();
    for (std::size_t k = 0; k < coordinates.size(); ++k)
      out.reach_p(place.i_p + static_cast<int>(k)) =
          coordinates[k].dimension == input::dim::length ? 1.0 : out.length;
    for (std::size_t k = 0; k < speeds.size(); ++k)
      out.reach_v(place.i_v + static_cast<int>(k)) =
          speeds[k].dimension == input::dim::velocity ? 1.0 : out.length;
  }
  return out;
}

}  // namespace flexura::mbs
