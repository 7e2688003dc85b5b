// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/maker.hpp"
#include "tests/mbs/random/scene/scene_physics.hpp"

/// Wheels and curves, and elements that touch, switch, rub and hold in six directions.
namespace flexura::mbs::chance {

void Maker::decorate_more() {
  const char* const types[] = {"bushing", "contact", "joint_friction", "actuator", "joint_force"};
  const int n_bodies = static_cast<int>(s_.bodies.size());
  for (int n = 1 + second_.below(3); n > 0; --n) {
    SceneForce f;
    const struct { int A, B; } between{second_.below(n_bodies), 1 + second_.below(n_bodies - 1)};
    f.type = second_.one_of(types);
    if (f.is_along_joint()) {
      if (along_joint(f)) s_.forces.push_back(f);
      continue;
    }
    if (between.A == between.B) continue;
    const Pose X_W = {second_.rotation(), s_.bodies[between.B].X_WB * second_.vector(0.3)};
    f.F = marker_at(between.A, X_W);
    f.M = marker_at(between.B, f.type == "bushing" ? bushing(f, X_W) : contact(f, X_W));
    s_.forces.push_back(f);
  }
}

// Between a frame that stands at X_W and the pose that is returned.
Pose Maker::bushing(SceneForce& f, const Pose& X_W) {
  const Pose X_WM = X_W * Pose{rotation_exp(second_.vector(0.1)), second_.vector(0.02)};
  f.stiffness = std::exp(second_.between(5.0, 9.0));
  f.turn_stiffness = std::exp(second_.between(1.0, 4.0));
  if (second_.flip(0.4)) f.damping = 0.01 * f.stiffness, f.turn_damping = 0.01 * f.turn_stiffness;
  return X_WM;
}

Pose Maker::contact(SceneForce& f, const Pose& X_W) {
  f.radius = second_.flip(0.3) ? 0.0 : second_.between(0.01, 0.1);
  const double x = second_.between(-0.2, 0.2), gap = second_.between(-0.001, 0.02);
  f.exponent = second_.flip(0.5) ? 1.0 : 1.5;
  f.stiffness = std::exp(second_.between(7.0, 11.0));
  if (second_.flip(0.4)) f.damping = second_.between(1.0, 20.0);
  return X_W * Pose{Matrix3d::Identity(), {x, 0.0, f.radius + gap}};
}

bool Maker::along_joint(SceneForce& f) {
  if (s_.joints.empty()) return false;
  f.joint = second_.below(static_cast<int>(s_.joints.size()));
  const SceneJoint& joint = s_.joints[f.joint];
  const auto& coordinates = coordinates_of(joint.type);
  // Angles of joints that close loops end the run where they jump (turn_watch.hpp).
  if (coordinates.empty() || joint.closes || joint.is_connection || joint.type == "universal" ||
      joint.type == "screw" || joint.type == "point_on_line" || joint.type == "point_on_plane")
    return false;
  f.coordinate = second_.below(static_cast<int>(coordinates.size()));
  const bool turns = coordinates[f.coordinate].is_angle();
  const double size = turns ? 2.0 : 10.0;
  if (f.type == "joint_friction") {
    f.coulomb = size * second_.between(0.05, 1.0);
    f.transition = turns ? 0.3 : 0.05;
    if (second_.flip(0.5)) f.damping = 0.1 * f.coulomb;
    return true;
  }
  f.level[0] = size * second_.between(-1.0, 1.0);
  f.level[1] = size * second_.between(-1.0, 1.0);
  f.time_constant = second_.between(0.01, 0.1);
  f.start = second_.flip(0.5) ? 0.0 : f.level[0];
  f.at = f.type == "actuator"
             ? second_.between(0.02, 0.2)
             : start_of(f.joint, f.coordinate) + second_.between(-0.2, 0.2) * (turns ? 1.0 : 0.2);
  return true;
}

// A body of its own that rolls over a plane and is held to another one by a spring.
void Maker::add_wheel() {
  std::swap(chance_, second_);  // bodies and poses are drawn from the former
  const Pose plane = pose(0.5);
  std::swap(chance_, second_);
  const struct {
    double lean, turn, radius, along;
  } stands{second_.between(-0.5, 0.5), second_.between(-3.0, 3.0), second_.between(0.1, 0.3),
           second_.between(-0.3, 0.3)};
  // The disc's axis is level but for its lean; its centre stands radius * cos(lean) above the plane.
  const Matrix3d R =
      rotation_exp({0, 0, stands.turn}) * rotation_exp({0.5 * std::numbers::pi + stands.lean, 0, 0});
  const Pose disc = plane * Pose{R, {stands.along, 0.1, stands.radius * std::cos(stands.lean)}};
  const int other = second_.below(static_cast<int>(s_.bodies.size()));
  std::swap(chance_, second_);
  const int wheel = body(disc * pose(0.02));
  std::swap(chance_, second_);
  s_.bodies[wheel].velocity = second_.vector(1.0);
  s_.bodies[wheel].angular_velocity = second_.vector(4.0);
  SceneConstraint c;
  c.type = "rolling_disc";
  c.length = stands.radius;
  c.F = marker_at(0, plane);
  c.M = marker_at(wheel, disc);
  s_.constraints.push_back(c);
  s_.what += ", a disc rolls";
  SceneForce f;
  f.type = "spring_damper";
  f.F = s_.add_marker(other, {second_.rotation(), second_.vector(0.3)});
  f.M = marker_at(wheel, disc);
  f.rest = (s_.marker(f.F, s_.places()).p - disc.p).norm();
  f.stiffness = second_.between(1.0, 50.0);
  if (f.rest > 0.15) s_.forces.push_back(f);
}

// A point of a body stays on a curve of another, where that leaves a freedom.
void Maker::add_curve() {
  const int n = static_cast<int>(s_.bodies.size()), A = second_.below(n), B = second_.below(n);
  if (A == B) return;
  const Scene before = s_;
  SceneConstraint c;
  c.type = "point_on_curve";
  for (const double x : {-0.4, -0.12, 0.15, 0.45})
    c.points.push_back(Vector3d{x, second_.between(-0.1, 0.1), second_.between(-0.05, 0.05)});
  const SceneCurve curve(c.points);
  const Pose X_W = {second_.rotation(), s_.bodies[B].X_WB * second_.vector(0.2)};
  const double s = 0.5 * (curve.knots()[1] + curve.knots()[2]);
  c.F = marker_at(A, X_W);
  c.M = marker_at(B, X_W * Pose{Matrix3d::Identity(), curve.at(s)});
  s_.constraints.push_back(c);
  const ScenePhysics physics(s_), without(before);
  const ScenePhysics::Rank rank = physics.rank(s_.places(), 0.0), less = without.rank(before.places(), 0.0);
  if (physics.n_freedoms() == rank.rank || rank.rank != less.rank + 2 || rank.smallest < 0.02)
    s_ = before;
  else
    s_.what += ", a point on a curve";
}

}  // namespace flexura::mbs::chance
