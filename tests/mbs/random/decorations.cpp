// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <string>

#include "tests/mbs/random/maker.hpp"

/// Springs and loads.
namespace flexura::mbs::chance {

void Maker::decorate() {
  for (int n = chance_.below(4); n > 0; --n) {
    SceneForce f;
    const int kind = chance_.below(4);
    if (kind == 0 ? spring(f) : kind == 1 ? joint_spring(f) : load(f)) s_.forces.push_back(f);
  }
}

bool Maker::spring(SceneForce& f) {
  const int n_bodies = static_cast<int>(s_.bodies.size());
  const int A = chance_.below(n_bodies), B = chance_.below(n_bodies);
  if (A == B) return false;
  f.type = "spring_damper";
  f.F = s_.add_marker(A, {chance_.rotation(), chance_.vector(0.3)});
  f.M = s_.add_marker(B, {chance_.rotation(), chance_.vector(0.3)});
  const double length = (s_.marker(f.F, s_.places()).p - s_.marker(f.M, s_.places()).p).norm();
  if (length < 0.15) return false;
  f.stiffness = std::exp(chance_.between(1.0, 6.0));
  f.rest = length * chance_.between(0.8, 1.2);
  if (chance_.flip(0.4)) f.damping = chance_.between(0.1, 5.0);
  return true;
}

bool Maker::joint_spring(SceneForce& f) {
  if (s_.joints.empty()) return false;
  f.joint = chance_.below(static_cast<int>(s_.joints.size()));
  const SceneJoint& joint = s_.joints[f.joint];
  const auto& coordinates = coordinates_of(joint.type);
  if (coordinates.empty() || joint.is_connection || joint.type == "universal" ||
      joint.type == "point_on_line" || joint.type == "point_on_plane")
    return false;
  f.type = "joint_spring_damper";
  f.coordinate = chance_.below(static_cast<int>(coordinates.size()));
  const bool turns = coordinates[f.coordinate].is_angle();
  f.stiffness = turns ? chance_.between(0.5, 30.0) : chance_.between(10.0, 500.0);
  if (chance_.flip(0.4)) f.damping = 0.02 * f.stiffness;
  f.rest = turns ? chance_.between(-0.5, 0.5) : chance_.between(-0.1, 0.1);
  return true;
}

bool Maker::load(SceneForce& f) {
  if (chance_.flip(0.5)) return false;
  f.type = chance_.flip(0.5) ? "force" : "torque";
  const int b = 1 + chance_.below(static_cast<int>(s_.bodies.size()) - 1);
  f.M = s_.add_marker(b, {chance_.rotation(), chance_.vector(0.3)});
  for (Law& law : f.law) {
    law.a = chance_.between(-1.0, 1.0) * (f.type == "force" ? 10.0 : 1.0);
    if (chance_.flip(0.3)) law.c = 5.0 * law.a, law.w = chance_.between(2.0, 15.0);
  }
  return true;
}

}  // namespace flexura::mbs::chance
