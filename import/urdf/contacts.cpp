// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/contacts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "import/urdf/at_start.hpp"

namespace flexura::import::urdf {
namespace {

// Where Gazebo's tags say nothing: its own friction; the weight of the robot presses one contact in by a millimetre, and it bounces
// with this damping ratio.
constexpr double kFriction = 1.0, kYield = 1e-3, kDampingRatio = 0.3, kGravity = 9.81;

constexpr int kRimPoints = 8;
constexpr std::size_t kMostContacts = 2000;

// No joint that moves leads to them from the ground.
std::vector<bool> standing(const Robot& robot) {
  std::vector<bool> stands(robot.links.size());
  stands[static_cast<std::size_t>(robot.root)] = true;
  for (const int j : robot.order) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(j)];
    stands[static_cast<std::size_t>(joint.child)] =
        joint.kind == JointKind::fixed && stands[static_cast<std::size_t>(joint.parent)];
  }
  return stands;
}

}  // namespace

std::vector<Ball> balls_of(const Shape& shape) {
  std::vector<Ball> out;
  const auto add = [&](double x, double y, double z, double radius) {
    out.push_back({shape.X_LS * Vector3d(x, y, z), radius});
  };
  const double half = 0.5 * shape.length;
  switch (shape.kind) {
    case Shape::Kind::sphere:
      add(0, 0, 0, shape.radius);
      break;
    case Shape::Kind::capsule:
      for (const double side : {-half, half}) add(0, 0, side, shape.radius);
      break;
    case Shape::Kind::box:
      for (int i = 0; i < 8; ++i)
        add(shape.size.x() * ((i & 1) - 0.5), shape.size.y() * ((i >> 1 & 1) - 0.5),
            shape.size.z() * ((i >> 2 & 1) - 0.5), 0.0);
      break;
    case Shape::Kind::cylinder:
      if (shape.length < 2.0 * shape.radius) {
        add(0, 0, 0, shape.radius);
        break;
      }
      for (const double side : {-half, half})
        for (int k = 0; k < kRimPoints; ++k) {
          const double angle = 2.0 * std::numbers::pi * k / kRimPoints;
          add(shape.radius * std::cos(angle), shape.radius * std::sin(angle), side, 0.0);
        }
      break;
    case Shape::Kind::mesh:
      break;
  }
  return out;
}

void add_floor(const Robot& robot, const std::vector<double>& q, Mechanism& mechanism, Names& names,
               Findings& findings) {
  const std::vector<Pose> X_WL = link_poses(robot, q);
  const std::vector<bool> stands = standing(robot);
  double mass = 0.0, floor = 0.0;
  std::size_t n = 0;
  const std::string floor_name = names.add("floor");
  for (std::size_t l = 0; l < mechanism.bodies.size(); ++l) {
    mass += mechanism.bodies[l].mass;
    if (stands[l]) continue;
    for (const Shape& shape : robot.links[l].collisions)
      for (const Ball& ball : balls_of(shape))
        floor = std::min(floor, (X_WL[l] * ball.center).z() - ball.radius);
  }
  for (std::size_t l = 0; l < mechanism.bodies.size(); ++l) {
    if (stands[l]) continue;
    const Link& link = robot.links[l];
    Body& body = mechanism.bodies[l];
    const double k = link.touch.stiffness > 0.0 ? link.touch.stiffness : mass * kGravity / kYield,
                 d = link.touch.damping >= 0.0 ? link.touch.damping
                                               : 2.0 * kDampingRatio * std::sqrt(k * mass),
                 mu = link.touch.friction >= 0.0 ? link.touch.friction : kFriction;
    std::size_t meshes = 0;
    for (const Shape& shape : link.collisions) {
      meshes += shape.kind == Shape::Kind::mesh ? 1 : 0;
      for (const Ball& ball : balls_of(shape)) {
        if (++n > kMostContacts)
          throw std::invalid_argument(
              fmt::format("{}: its collision shapes make more than {} contacts; leave "
                          "--contacts out, or take shapes away",
                          robot.file.string(), kMostContacts));
        const std::string name = names.add(body.name + "_touch");
        body.markers.push_back({name, {Matrix3d::Identity(), ball.center}});
        mechanism.elements.push_back({"force",
                                      name,
                                      {},
                                      {{"type", toml(std::string("contact"))},
                                       {"from", toml("ground." + floor_name)},
                                       {"to", toml(body.name + "." + name)},
                                       {"radius", toml(ball.radius)},
                                       {"stiffness", toml(k)},
                                       {"damping", toml(d)},
                                       {"friction", toml(mu)}}});
      }
    }
    if (meshes > 0)
      findings.note("links whose meshes touch nothing",
                    fmt::format("link \"{}\": {} collision mesh{} no contact; simple shapes do",
                                shown(link.name), meshes, meshes == 1 ? " makes" : "es make"));
  }
  if (n == 0) {
    findings.note("robots without contacts",
                  "no link that moves has a simple collision shape: --contacts makes none");
    return;
  }
  mechanism.ground.push_back({floor_name, {Matrix3d::Identity(), Vector3d(0.0, 0.0, floor)}});
  findings.note(
      "floors",
      fmt::format("{} contacts with the floor z = {:.6g} m: cylinders by points of their rims, wheels "
                  "(shorter than wide) by balls; where Gazebo's kp, kd and mu1 are not given a contact "
                  "yields 1 mm under the robot's weight, its friction is {}",
                  n, floor, kFriction));
}

}  // namespace flexura::import::urdf
