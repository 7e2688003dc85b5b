// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "import/model/findings.hpp"
#include "import/model/mechanism.hpp"
#include "import/xml/node.hpp"

/// An MJCF file as it stands, with what it includes: settings of its compiler, classes of defaults, assets.
/// Format: mujoco.readthedocs.io, XML reference (of version 3).
namespace flexura::import::mjcf {

using xml::Node;

struct Compiler {
  bool degree = true, autolimits = true, global = false, balance_inertia = false, strip_path = false;
  std::string euler_sequence = "xyz", mesh_folder;
  enum class FromGeoms { when_missing, always, never } from_geoms = FromGeoms::when_missing;
  double least_mass = 0.0, least_inertia = 0.0, total_mass = -1.0;
  int first_group = 0, last_group = 5;  ///< of geoms that count for inertias
};

struct Option {
  Vector3d gravity = {0.0, 0.0, -9.81}, wind = Vector3d::Zero();
  double density = 0.0, viscosity = 0.0;
  bool springs = true, dampers = true, limits = true, friction = true, equality = true, actuation = true,
       clamp_controls = true;
};

/// Settings of classes; a class has what those around it say and it does not.
class Defaults {
 public:
  Defaults() = default;
  Defaults(const Node& root, Findings& findings);
  bool has(const std::string& name) const { return classes_.contains(name); }
  /// The element with what its class (its own, else `otherwise`) says under what it says itself.
  Node applied(const Node& element, const std::string& otherwise, Findings& findings) const;
  /// The class's settings for actuators in the order in which they act: all kinds of actuators set the same one.
  std::vector<Node> actuators(const Node& element, Findings& findings) const;

 private:
  struct Class {
    std::map<std::string, Node> by_tag;
    std::vector<Node> actuators;
  };
  void read(const Node& element, const std::string& name, const Class& around, Findings& findings);
  const Class* of(const Node& element, const std::string& otherwise, Findings& findings) const;

  std::map<std::string, Class> classes_;
};

struct Model {
  std::filesystem::path file;
  Node root;
  Compiler compiler;
  Option option;
  Defaults defaults;
  std::map<std::string, Node> meshes;                    ///< <mesh> with defaults, by name
  std::map<std::string, std::shared_ptr<Model>> models;  ///< <model>, to be attached
  std::string missing_include;                           ///< for messages about what may have stood there

  std::vector<const Node*> sections(const std::string& tag) const { return root.all(tag); }
};

/// Throws std::invalid_argument where the file is no MJCF; included files that are not there are repairs, models to be
/// attached faults.
std::shared_ptr<Model> read_model(const std::filesystem::path& file, Findings& findings);

/// pos, and quat, axisangle, euler, xyaxes or zaxis.
Pose pose_of(const Node& element, const Compiler& compiler, Findings& findings);
Matrix3d rotation_by_euler(const Vector3d& angles, const Compiler& compiler);
bool has_orientation(const Node& element);

}  // namespace flexura::import::mjcf
