// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "import/model/inertia.hpp"
#include "import/model/mechanism.hpp"

/// A multibody system as foreign formats describe it, before it becomes a mechanism.  All in SI.
namespace flexura::import::tree {

using Inertial = MassProperties;

/// A simple solid about its own origin.  size: half lengths of a box, half axes of an ellipsoid, radius of a sphere, radius and half length
/// (of a capsule: of its cylinder) along z.
struct Solid {
  enum class Kind { box, sphere, cylinder, capsule, ellipsoid, surface } kind = Kind::sphere;
  Pose X_LS;
  Vector3d size = Vector3d::Zero();
  Surface surface = {};  ///< of the kind surface
  std::string color = {};
};

struct Link {
  std::string name;
  Inertial inertial = {};
  std::vector<Solid> solids = {};
  std::vector<std::string> comments = {};
};

enum class JointKind { fixed, revolute, prismatic, screw, spherical, free };

/// Marker F in the parent and M in the child; coordinates are of M relative to F, along and about z.
struct Joint {
  std::string name;
  int line = 0;  ///< for messages; 0: of another file
  JointKind kind = JointKind::fixed;
  int parent = -1, child = 0;  ///< links; -1: the ground
  Pose X_PF, X_CM;
  bool closes_loop = false;
  bool reversed = false;   ///< the child is nearer to the ground than the parent
  double start = 0.0;      ///< coordinate of the kinds with one
  Pose X_FM;               ///< at the start, of spherical and free
  double pitch = 0.0;      ///< of a screw [m]
  double stiffness = 0.0;  ///< of a spring; of spherical and free joints in all directions
  double rest = 0.0;       ///< coordinate without its force; spherical and free: as at the start
  double damping = 0.0;
  double friction = 0.0;  ///< Coulomb
  double armature = 0.0;  ///< inertia along the coordinate alone: of a rotor behind a gear
  std::optional<double> lower = {}, upper = {};
  /// Of elastic stops: angular frequency [rad/s] with what the joint carries, and damping ratio.
  double stop_frequency = 0.0, stop_damping_ratio = 0.0;
  std::vector<std::string> comments = {};

  int inner() const { return reversed ? child : parent; }
  int outer() const { return reversed ? parent : child; }
  bool has_one_coordinate() const {
    return kind == JointKind::revolute || kind == JointKind::prismatic || kind == JointKind::screw;
  }
  bool turns() const { return kind != JointKind::prismatic; }
  int freedoms() const {
    return kind == JointKind::fixed ? 0 : kind == JointKind::spherical ? 3 : kind == JointKind::free ? 6 : 1;
  }
};

/// Every link is reached from the ground by joints that do not close loops, the inner one of two before the outer.
struct Tree {
  std::string name, file;
  Vector3d gravity = {0.0, 0.0, -9.81};
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<Solid> ground;  ///< solids of the ground
  std::vector<std::string> comments;
};

/// Of M relative to F at the start.
Pose start_motion(const Joint& joint);

/// X_WL of every link at the start.
std::vector<Pose> start_poses(const Tree& tree);

}  // namespace flexura::import::tree
