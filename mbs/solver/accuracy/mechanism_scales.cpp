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

// A body whose stiffness is a matrix says of its coordinates what they do to its nodes, and of those that do nothing there what
// they do on the average of its mass.  Turning counts by the length of the body, that of a straight one with its inertia.
double reach_of(const FlexibleBody& body, int i, double length, NodeMotion& node) {
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(body.m());
  double reach = 0.0;
  for (std::size_t k = 0; k < body.nodes().size(); ++k) {
    body.node_motion(static_cast<int>(k), rest.data(), nullptr, nullptr, node);
    reach = std::max({reach, node.map.col(i).tail<3>().norm(), length * node.map.col(i).head<3>().norm()});
  }
  return reach > 0.0 ? reach : std::sqrt(body.M_e()(i, i) / body.mass());
}

// Of the coordinates of such bodies, whose amplitudes would be those of modes of unit mass: reaches, and the frequencies that
// each has alone, what hangs on the body at rest; no vibration that it takes part in is faster.
void take_far_bending(const Mechanism& mechanism, const State& s, Scales& out) {
  const Sizes n = mechanism.sizes();
  const MechanismDescription& d = mechanism.description();
  out.frequency.setZero(n.n_v);
  Eigen::VectorXd own_mass = Eigen::VectorXd::Zero(n.n_p), reach = own_mass;
  for (std::size_t b = 1; b < d.bodies.size(); ++b) {
    const FlexibleBody* body = mechanism.deforming(static_cast<int>(b));
    const int first = mechanism.modal_position(static_cast<int>(b));
    if (!body || first < 0) continue;
    own_mass.segment(first, body->m()) = body->M_e().diagonal();
    const RigidInertia I = body->undeformed_inertia();
    const double about_center = I.inertia.trace() / I.mass - 2.0 * (I.mass_center / I.mass).squaredNorm();
    const double length = std::sqrt(6.0 * std::max(0.0, about_center));
    NodeMotion node = body->make_node_motion();
    for (int i = 0; i < body->m(); ++i) {
      if (const auto alone = body->alone(i)) {
        reach(first + i) = alone->reach;
        own_mass(first + i) = alone->mass;
      } else if (body->amplitude(i) == body->FlexibleBody::amplitude(i)) {
        reach(first + i) = reach_of(*body, i, length, node);
      }
    }
  }
  if (own_mass.isZero(0.0)) return;
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n.n_v, n.n_p), D = Eigen::MatrixXd::Zero(n.n_v, n.n_v);
  mechanism.add_elastic_tangents(s, K, D);
  for (int i = 0; i < n.n_v; ++i) {
    int i_p = -1;
    double spring = 0.0, damper = 0.0;
    if (!mechanism.elastic_coordinate(i, i_p, spring, damper) || spring > 0.0) continue;
    if (reach(i_p) > 0.0) out.reach_p(i_p) = out.reach_v(i) = reach(i_p);
    if (K(i, i_p) > 0.0 && own_mass(i_p) > 0.0) out.frequency(i) = std::sqrt(K(i, i_p) / own_mass(i_p));
  }
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
  take_far_bending(mechanism, s, out);
  return out;
}

}  // namespace flexura::mbs
