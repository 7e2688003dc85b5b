// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/differences.hpp"
#include "tests/mbs/random/scene/scene_physics.hpp"

/// Springs, loads, contacts and what acts along joints: put at markers, by virtual work on the bodies' coordinates.
namespace flexura::mbs::chance {

// The turn of a marker on a flexible body per modal coordinate is a difference, of the axes and the origin.
Eigen::MatrixXd ScenePhysics::marker_map(int m, const Places& places) const {
  const int b = scene_.markers[m].body;
  if (b == 0) return Eigen::MatrixXd::Zero(6, 0);
  const Pose X = marker(m, places);
  Eigen::MatrixXd map = Eigen::MatrixXd::Zero(6, scene_.bodies[b].n_dofs());
  map.leftCols<6>().setIdentity();
  for (int i = 0; i < 3; ++i) map.col(i).tail<3>() = Vector3d::Unit(i).cross(X.p - places[b].X_WB.p);
  Places moved = places;
  for (int i = 0; i < scene_.bodies[b].modes; ++i) {
    map.col(6 + i) = first_difference(
        [&](double h) {
          moved[b].q(i) = places[b].q(i) + h;
          const Pose there = marker(m, moved);
          Eigen::VectorXd way(6);
          way << rotation_log(there.R * X.R.transpose()), there.p;
          return way;
        },
        kFirst);
    moved[b].q(i) = places[b].q(i);
  }
  return map;
}

Spatial ScenePhysics::marker_twist(int m, const Places& places, const Eigen::VectorXd& v) const {
  const int b = scene_.markers[m].body;
  Vector6d twist = Vector6d::Zero();
  if (b > 0) twist = marker_map(m, places) * v.segment(first(b), scene_.bodies[b].n_dofs());
  return {twist.head<3>(), twist.tail<3>()};
}

Eigen::VectorXd ScenePhysics::forces(const std::vector<BodyMotion>& motion, double t) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(n_);
  const Places X = places_of(motion);
  const Eigen::VectorXd v = speeds(motion);
  const auto put = [&](int m, const Vector3d& at, const Vector3d& force, const Vector3d& torque) {
    const int b = scene_.markers[m].body;
    if (b == 0) return;
    Vector6d wrench;
    wrench << torque + (at - marker(m, X).p).cross(force), force;
    f.segment(first(b), scene_.bodies[b].n_dofs()) += marker_map(m, X).transpose() * wrench;
  };
  // Of the point of the marker's body that stands at `at`.
  const auto velocity = [&](int m, const Vector3d& at) {
    const Spatial V = marker_twist(m, X, v);
    return Vector3d(V.linear + V.angular.cross(at - marker(m, X).p));
  };
  for (int b = 1; b < n_bodies(); ++b)
    f.segment(first(b), scene_.bodies[b].n_dofs()) += body_forces(b, motion[b]);
  const Vector3d none = Vector3d::Zero();
  for (const SceneForce& force : scene_.forces) {
    if (force.type == "spring_damper") {
      const Vector3d P = marker(force.F, X).p, Q = marker(force.M, X).p, r = Q - P, e = r.normalized();
      const double tension = force.stiffness * (r.norm() - force.rest) +
                             force.damping * e.dot(velocity(force.M, Q) - velocity(force.F, P));
      put(force.F, P, tension * e, none);
      put(force.M, Q, -tension * e, none);
    } else if (force.type == "bushing") {
      for (const int b : {scene_.markers[force.F].body, scene_.markers[force.M].body})
        for (int i = first(b); b > 0 && i < first(b) + scene_.bodies[b].n_dofs(); ++i)
          f(i) -= slope(
              [&](double h) { return bushing_energy(force, moved(X, h * Eigen::VectorXd::Unit(n_, i))); },
              kFirst);
      const Vector3d at = marker(force.M, X).p;
      const Vector3d pull = -force.damping * (velocity(force.M, at) - velocity(force.F, at)),
                     twist = -force.turn_damping *
                             (marker_twist(force.M, X, v).angular - marker_twist(force.F, X, v).angular);
      put(force.M, at, pull, twist);
      put(force.F, at, -pull, -twist);
    } else if (force.type == "contact") {
      const Vector3d n = marker(force.F, X).R.col(2), at = marker(force.M, X).p - force.radius * n;
      const double push = contact_push(force, motion);
      put(force.M, at, push * n, none);
      put(force.F, at, -push * n, none);
    } else if (force.is_along_joint()) {
      const SceneJoint& joint = scene_.joints[force.joint];
      const NamedCoordinate& c = coordinates_of(joint.type)[force.coordinate];
      const Matrix3d R_WF = marker(joint.F, X).R;
      const double size = along_joint(force, motion, t);
      const Vector3d at = marker(joint.M, X).p;
      const int axis = c.what == Coordinate::slide_x ? 0 : c.what == Coordinate::slide_y ? 1 : 2;
      const Vector3d along = size * R_WF.col(axis);
      put(joint.M, at, c.is_angle() ? none : along, c.is_angle() ? along : none);
      put(joint.F, at, c.is_angle() ? none : Vector3d(-along), c.is_angle() ? Vector3d(-along) : none);
    } else {
      const Vector3d value(force.law[0].value(t), force.law[1].value(t), force.law[2].value(t));
      const bool turns = force.type == "torque";
      put(force.M, marker(force.M, X).p, turns ? none : value, turns ? value : none);
    }
  }
  return f;
}

double ScenePhysics::along_joint(const SceneForce& force, const std::vector<BodyMotion>& motion,
                                 double t) const {
  if (force.type == "actuator") return force.actuator_force(t);
  const double q = value(force.joint, force.coordinate, places_of(motion));
  if (force.type == "joint_force") return force.level[q > force.at ? 1 : 0];
  const double rate = speed(force.joint, force.coordinate, motion);
  return force.type == "joint_friction"
             ? -force.coulomb * std::tanh(rate / force.transition) - force.damping * rate
             : -force.stiffness * (q - force.rest) - force.damping * rate;
}

double ScenePhysics::bushing_energy(const SceneForce& force, const Places& X) const {
  const Pose X_FM = marker(force.F, X).inverse() * marker(force.M, X);
  return 0.5 * force.stiffness * X_FM.p.squaredNorm() +
         0.5 * force.turn_stiffness * rotation_log(X_FM.R).squaredNorm();
}

double ScenePhysics::gap(const SceneForce& force, const Places& X) const {
  return (marker(force.F, X).inverse() * marker(force.M, X)).p.z() - force.radius;
}

double ScenePhysics::contact_push(const SceneForce& force, const std::vector<BodyMotion>& motion) const {
  const Places X = places_of(motion);
  const double deep = -gap(force, X);
  if (deep <= 0.0) return 0.0;
  const Eigen::VectorXd v = speeds(motion);
  const double rate = -slope([&](double h) { return gap(force, moved(X, h * v)); }, kFirst * calm(v));
  return std::max(0.0, force.stiffness * std::pow(deep, force.exponent) + force.damping * rate);
}

bool ScenePhysics::stands_at_switch(const std::vector<BodyMotion>& motion, double t) const {
  constexpr double kNear = 1e-5;
  const Places X = places_of(motion);
  // A spline's third derivative jumps at its knots, over which differences look.
  const bool at_knot = std::ranges::any_of(scene_.constraints, [&](const SceneConstraint& c) {
    if (c.type != "point_on_curve") return false;
    const SceneCurve curve(c.points);
    const double s = curve.foot((marker(c.F, X).inverse() * marker(c.M, X)).p);
    return std::ranges::any_of(curve.knots(), [&](double knot) { return std::abs(s - knot) < 0.02 * size_; });
  });
  return at_knot || std::ranges::any_of(scene_.forces, [&](const SceneForce& force) {
           return (force.type == "contact" && std::abs(gap(force, X)) < kNear * size_) ||
                  (force.type == "joint_force" &&
                   std::abs(value(force.joint, force.coordinate, X) - force.at) < kNear) ||
                  (force.type == "actuator" && std::abs(t - force.at) < kNear);
         });
}

double ScenePhysics::potential(const std::vector<BodyMotion>& motion) const {
  const Places X = places_of(motion);
  double U = 0.0;
  U -= mass() * scene_.gravity.dot(centre(motion));
  for (int b = 1; b < n_bodies(); ++b) U += 0.5 * X[b].q.dot(points_[b].omega2.cwiseProduct(X[b].q));
  for (const SceneForce& force : scene_.forces) {
    double stretch = 0.0;
    if (force.type == "bushing") U += bushing_energy(force, X);
    if (force.type == "contact")
      // A surface that is left faster than it comes back keeps nothing.
      if (contact_push(force, motion) > 0.0)
        U += force.stiffness / (force.exponent + 1.0) * std::pow(-gap(force, X), force.exponent + 1.0);
    if (force.type == "spring_damper")
      stretch = (marker(force.M, X).p - marker(force.F, X).p).norm() - force.rest;
    else if (force.type == "joint_spring_damper")
      stretch = value(force.joint, force.coordinate, X) - force.rest;
    U += 0.5 * force.stiffness * stretch * stretch;
  }
  return U;
}

}  // namespace flexura::mbs::chance
