// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "import/model/mechanism.hpp"

/// A URDF as it stands: links, joints, transmissions, checked one by one and as a tree.
/// Format: wiki.ros.org/urdf/XML (link, joint, transmission).
namespace flexura::import::urdf {

enum class JointKind { revolute, continuous, prismatic, fixed, floating, planar };

struct Inertial {
  double mass = 0.0;
  Vector3d center = Vector3d::Zero();   ///< link frame
  Matrix3d inertia = Matrix3d::Zero();  ///< about the centre, axes of the link
};

struct Visual {
  enum class Kind { box, cylinder, sphere, mesh } kind = Kind::box;
  Pose X_LV;                          ///< of the shape in the link
  Vector3d size = Vector3d::Ones();   ///< box: lengths; mesh: scale
  double radius = 0.0, length = 0.0;  ///< of a cylinder about z, of a sphere
  std::string mesh, color;            ///< "#rrggbb" or empty
};

struct Link {
  std::string name;
  int line = 0;
  std::optional<Inertial> inertial;
  std::vector<Visual> visuals;
  int parent_joint = -1;  ///< index; -1: the root
};

struct Limit {
  double lower = 0.0, upper = 0.0, effort = 0.0, velocity = 0.0;
};

struct Mimic {
  int joint = -1;
  double multiplier = 1.0, offset = 0.0;
};

struct Joint {
  std::string name;
  int line = 0;
  JointKind kind = JointKind::fixed;
  int parent = -1, child = -1;        ///< links
  Pose X_PJ;                          ///< of the joint's (and child's) frame in the parent
  Vector3d axis = Vector3d::UnitX();  ///< unit vector in the joint's frame
  std::optional<Limit> limit;         ///< with effort = velocity = 0 where they are not given
  double damping = 0.0, friction = 0.0;
  std::optional<Mimic> mimic;
};

/// A motor on a joint: the joint gets `reduction` times the actuator's effort.
struct Transmission {
  std::string name, actuator;
  int joint = -1;
  double reduction = 1.0;
};

struct Robot {
  std::string name;
  std::filesystem::path file;
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<Transmission> transmissions;
  int root = -1;
  std::vector<int> order;          ///< joints from the root outwards
  std::vector<std::string> notes;  ///< what was passed over
};

/// Throws std::invalid_argument with file, line, value, rule and remedy.
Robot read_robot(const std::filesystem::path& file);

}  // namespace flexura::import::urdf
