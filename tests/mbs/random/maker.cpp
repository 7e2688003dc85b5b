// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/maker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/scene/scene_physics.hpp"

/// Bodies on joints, speeds and drives.
namespace flexura::mbs::chance {

namespace {
constexpr double kTurn = 2.0 * std::numbers::pi;
Matrix3d about_z(double angle) {
  return rotation_exp({0.0, 0.0, angle});
}
}  // namespace

int Maker::body(const Pose& X_WB) {
  SceneBody b;
  b.mass = std::exp(chance_.between(std::log(0.3), std::log(5.0)));
  b.center = chance_.flip(0.5) ? Vector3d::Zero() : chance_.vector(0.15);
  const Vector3d box = {chance_.between(0.05, 0.5), chance_.between(0.05, 0.5), chance_.between(0.05, 0.5)};
  const Vector3d square = box.cwiseProduct(box);
  const Matrix3d R = chance_.flip(0.5) ? Matrix3d(Matrix3d::Identity()) : chance_.rotation();
  b.inertia =
      R * Vector3d(square.y() + square.z(), square.z() + square.x(), square.x() + square.y()).asDiagonal() *
      R.transpose() * (b.mass / 12.0);
  b.inertia = 0.5 * (b.inertia + b.inertia.transpose()).eval();
  b.X_WB = X_WB;
  s_.bodies.push_back(b);
  return static_cast<int>(s_.bodies.size()) - 1;
}

Pose Maker::joint_pose(const SceneJoint& joint) {
  const double turn = chance_.between(-1.2, 1.2), way = chance_.between(-0.2, 0.2);
  const std::string& type = joint.type;
  if (type == "revolute") return {about_z(turn), Vector3d::Zero()};
  if (type == "prismatic") return {Matrix3d::Identity(), {0, 0, way}};
  if (type == "cylindrical") return {about_z(turn), {0, 0, way}};
  if (type == "screw") return {about_z(turn), {0, 0, joint.pitch * turn / kTurn}};
  if (type == "planar") return {about_z(turn), {way, chance_.between(-0.2, 0.2), 0}};
  if (type == "spherical") return {chance_.rotation(), Vector3d::Zero()};
  if (type == "universal")
    return {rotation_exp({turn, 0, 0}) * rotation_exp({0, chance_.between(-1.0, 1.0), 0}), Vector3d::Zero()};
  if (type == "constant_velocity")
    return {rotation_exp({turn, chance_.between(-1.0, 1.0), 0}), Vector3d::Zero()};
  if (type == "fixed") return {};
  if (type == "orientation") return {Matrix3d::Identity(), chance_.vector(0.2)};
  if (type == "parallel") return {about_z(turn), chance_.vector(0.2)};
  if (type == "point_on_line") return {chance_.rotation(), {0, 0, way}};
  if (type == "point_on_plane") return {chance_.rotation(), {way, chance_.between(-0.2, 0.2), 0}};
  return {chance_.rotation(), chance_.vector(0.3)};  // free
}

int Maker::join(const std::string& type, int from, const Pose& X_WF, int to, const Pose& X_WM) {
  SceneJoint joint;
  joint.type = type;
  joint.F = marker_at(from, X_WF);
  joint.M = marker_at(to, X_WM);
  s_.joints.push_back(joint);
  return static_cast<int>(s_.joints.size()) - 1;
}

int Maker::grow(const std::string& type, int parent) {
  SceneJoint joint;
  joint.type = type;
  joint.pitch = type == "screw" ? chance_.either_sign(0.02, 0.3) : 0.0;
  const Pose X_FM = joint_pose(joint);
  const bool reversed = chance_.flip(0.2);
  const Pose X_W1 = s_.bodies[parent].X_WB * pose(0.3), X_B2 = pose(0.3);
  const int child = body(X_W1 * (reversed ? X_FM.inverse() : X_FM) * X_B2.inverse());
  joint.F = reversed ? s_.add_marker(child, X_B2) : marker_at(parent, X_W1);
  joint.M = reversed ? marker_at(parent, X_W1) : s_.add_marker(child, X_B2);
  s_.joints.push_back(joint);
  return child;
}

void Maker::grow_tree(int n, bool is_grounded) {
  static const char* const types[] = {
      "revolute", "revolute",    "prismatic", "cylindrical",       "screw",
      "planar",   "spherical",   "universal", "constant_velocity", "fixed",
      "free",     "orientation", "parallel",  "point_on_line",     "point_on_plane"};
  const int first = static_cast<int>(s_.bodies.size());
  for (int i = 0; i < n; ++i) {
    const int last = static_cast<int>(s_.bodies.size()) - 1;
    if (i == 0 && !is_grounded) {
      const int b = body(pose(0.5));
      s_.bodies[b].velocity = chance_.vector(1.0);
      s_.bodies[b].angular_velocity = chance_.vector(2.0);
      if (chance_.flip(0.5)) {
        const Pose X_F = pose(1.0), X_M = pose(0.2);
        join("free", 0, X_F, b, X_M);
      }
      continue;
    }
    const int parent = i == 0 ? 0 : chance_.flip(0.7) ? last : first + chance_.below(last - first + 1);
    grow(chance_.one_of(types), parent);
  }
}

void Maker::give_speeds(double probability) {
  for (SceneJoint& joint : s_.joints) {
    const auto& coordinates = coordinates_of(joint.type);
    if (joint.closes || joint.is_connection) continue;
    for (int i = 0; i < static_cast<int>(coordinates.size()); ++i)
      if (chance_.flip(probability))
        joint.speeds.emplace_back(i, chance_.between(-1.0, 1.0) * (coordinates[i].is_angle() ? 4.0 : 0.7));
  }
}

double Maker::start_of(int joint, int coordinate) const {
  return ScenePhysics(s_).coordinate(joint, coordinate, s_.places());
}

Law Maker::drive_law(int joint, int coordinate, double start) {
  const double size = coordinates_of(s_.joints[joint].type)[coordinate].is_angle() ? 1.0 : 0.15;
  Law law;
  law.b = size * chance_.between(-3.0, 3.0);
  if (chance_.flip(0.5)) {
    law.c = size * chance_.between(0.05, 0.3);
    law.w = chance_.between(2.0, 12.0);
    if (chance_.flip(0.5)) law.phi = chance_.between(-1.0, 1.0);
    if (chance_.flip(0.2)) law.b = 0.0;
  }
  law.a = start - law.c * std::sin(law.phi);
  return law;
}

void Maker::drives(int n) {
  for (int tries = 0; tries < 4 * n && n > 0; ++tries) {
    if (s_.joints.empty()) return;
    const int j = chance_.below(static_cast<int>(s_.joints.size()));
    SceneJoint& joint = s_.joints[j];
    const auto& coordinates = coordinates_of(joint.type);
    if (coordinates.empty() || joint.is_connection || !joint.drives.empty()) continue;
    const int i = chance_.below(static_cast<int>(coordinates.size()));
    if (!coordinates[i].can_be_driven) continue;
    joint.drives.push_back({i, drive_law(j, i, start_of(j, i)), chance_.below(3)});
    std::erase_if(joint.speeds, [&](const auto& given) { return given.first == i; });
    --n;
  }
}

}  // namespace flexura::mbs::chance
