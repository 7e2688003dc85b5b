// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "import/model/findings.hpp"
#include "import/model/inertia.hpp"
#include "import/model/mechanism.hpp"

/// A URDF as it stands: links, joints, transmissions, checked one by one and as a tree.
/// Format: wiki.ros.org/urdf/XML (link, joint, transmission).
namespace flexura::import::urdf {

/// Spherical joints ("spherical", "ball") are of Bullet and Drake, the others of the standard.
enum class JointKind { revolute, continuous, prismatic, fixed, floating, planar, spherical };

struct Shape {
  enum class Kind { box, cylinder, sphere, capsule, mesh } kind = Kind::box;
  Pose X_LS;                         ///< of the shape in the link
  Vector3d size = Vector3d::Ones();  ///< box: lengths; mesh: scale
  double radius = 0.0,
         length = 0.0;      ///< of a cylinder about z, of a sphere; of a capsule between its half spheres
  std::string mesh, color;  ///< "#rrggbb" or empty
};

/// What Gazebo's tags say of a link's surface; negative: nothing.
struct Touch {
  double friction = -1.0, stiffness = -1.0, damping = -1.0;
};

struct Link {
  std::string name;
  int line = 0;
  std::optional<MassProperties> inertial;  ///< in the link's frame
  std::vector<Shape> visuals, collisions;
  Touch touch;
  int parent_joint = -1;  ///< index; -1: the root
};

/// Lower and upper are infinite where there are none, effort and velocity 0.
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
  std::optional<Limit> limit;
  double damping = 0.0, friction = 0.0;
  std::optional<Mimic> mimic;
  bool is_driven = false;  ///< at its start: what it moves has no inertia
};

inline bool turns(const Joint& joint) {
  return joint.kind == JointKind::revolute || joint.kind == JointKind::continuous;
}
inline bool has_one_coordinate(const Joint& joint) {
  return turns(joint) || joint.kind == JointKind::prismatic;
}

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
  std::vector<int> order;  ///< joints from the root outwards
};

/// The file's text.  Throws std::invalid_argument where it cannot be read.
std::string read_text(const std::filesystem::path& file);

/// Reads `text`, what the file holds or what xacro made of it.  Throws Faults: all of them, each with file, line, value, rule and
/// remedy; std::invalid_argument where it is no robot at all.
Robot read_robot(const std::string& text, Findings& findings);

}  // namespace flexura::import::urdf
