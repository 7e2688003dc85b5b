// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/maker.hpp"
#include "tests/mbs/random/scene/scene_physics.hpp"

/// Trees, and loops of bodies in space.
namespace flexura::mbs::chance {

void Maker::tree() {
  const bool is_grounded = chance_.flip(0.6);
  s_.what = is_grounded ? "tree on ground" : "tree that floats";
  grow_tree(1 + chance_.below(4), is_grounded);
  give_speeds(0.7);
  drives(chance_.flip(0.5) ? 0 : 1 + chance_.below(2));
}

void Maker::spatial_loops() {
  s_.what = "spatial loops";
  grow_tree(2 + chance_.below(3), chance_.flip(0.85));
  static const char* const types[] = {"distance",      "distance",    "distance",        "point_on_plane",
                                      "point_on_line", "spherical",   "perpendicular",   "parallel",
                                      "orientation",   "cylindrical", "revolute",        "universal",
                                      "planar",        "prismatic",   "j point_on_plane"};
  const int loops = 1 + chance_.below(2);
  for (int tries = 0, made = 0; tries < 12 && made < loops; ++tries) {
    const int n = static_cast<int>(s_.bodies.size());
    const int A = chance_.below(n), B = chance_.below(n);
    if (A == B) continue;
    Scene before = s_;
    close(chance_.one_of(types), A, B);
    const ScenePhysics physics(s_);
    const int mobility = physics.n_freedoms() - physics.rank(s_.places(), 0.0).rank;
    if (mobility > 0 || chance_.flip(0.1))
      ++made;
    else
      s_ = before;
  }
  give_speeds(0.2);
  drives(chance_.below(3));
}

void Maker::close(std::string type, int A, int B) {
  const Pose at = {chance_.rotation(), s_.bodies[B].X_WB * chance_.vector(0.3)};
  const bool is_joint = type[0] == 'j' || type == "spherical" || type == "cylindrical" ||
                        type == "revolute" || type == "universal" || type == "planar" || type == "prismatic";
  if (type[0] == 'j') type = type.substr(2);
  if (is_joint) {
    SceneJoint joint;
    joint.type = type;
    const int j = join(type, A, at * joint_pose(joint).inverse(), B, at);
    s_.joints[j].closes = true;
    s_.joints[j].is_connection = chance_.flip(0.3);
    return;
  }
  SceneConstraint c;
  c.type = type;
  Pose at_A = at;
  if (type == "distance") {
    at_A.p = s_.bodies[A].X_WB * chance_.vector(0.4);
    c.length = (at_A.p - at.p).norm();
  } else if (type == "perpendicular") {
    at_A.R = at.R * rotation_exp({0.5 * std::numbers::pi, 0, 0});
    at_A.p = s_.bodies[A].X_WB * chance_.vector(0.4);
  } else {
    SceneJoint like;
    like.type = type;
    at_A = at * joint_pose(like).inverse();
  }
  c.F = marker_at(A, at_A);
  c.M = marker_at(B, at);
  s_.constraints.push_back(c);
}

}  // namespace flexura::mbs::chance
