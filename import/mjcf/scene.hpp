// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "import/mjcf/model.hpp"
#include "import/tree/tree.hpp"

namespace flexura::import::mjcf {

/// Names that a copy of a subtree has: attached models put something in front, replicas behind.
struct Scope {
  const Model* model = nullptr;
  std::string prefix, suffix;

  std::string full(const std::string& name) const { return prefix + name + suffix; }
};

/// A point of a link with axes.
struct Place {
  int link = -1;
  Pose X_LP;
};

/// A joint beside what the tree knows of it.
struct JointInfo {
  double spring_time = 0.0, spring_damping_ratio = 0.0;   ///< springdamper
  std::optional<std::pair<double, double>> motor_limits;  ///< actuatorfrcrange
};

/// The worldbody as links and joints, and what names of the other sections mean.
struct Scene {
  tree::Tree tree;
  std::map<std::string, int> bodies;  ///< links; "world" is -1
  std::map<std::string, int> joints;
  std::map<std::string, Place> sites;
  std::map<std::string, std::string> geoms;  ///< their kinds: tendons wrap round some
  std::map<int, JointInfo> joint_infos;
  std::vector<double> gravity_compensation;  ///< of each link
  std::vector<bool> moves;                   ///< links that a joint can move
  /// Of links, the axes in which the file gives the inertia: where two moments are equal the principal ones are not unique.
  std::map<int, Matrix3d> inertia_axes;
  std::set<int> ellipsoid_fluid;           ///< links with geoms of fluidshape "ellipsoid"
  std::vector<Scope> scopes;               ///< the file's own first
  std::map<std::string, int> passed_over;  ///< tags and how often
};

/// Reads the worldbody of the model and of those attached.
Scene read_scene(const Model& model, Findings& findings);

/// What `name` means in this copy: its own thing of that name, else that of the file.
template <class T>
const T* find(const std::map<std::string, T>& things, const Scope& scope, const std::string& name) {
  const auto own = things.find(scope.full(name));
  const auto found = own == things.end() ? things.find(name) : own;
  return found == things.end() ? nullptr : &found->second;
}

/// The copies of an element of a model's sections: scopes in which all `names` mean something, given (map of names, name).
/// A fault where there is none and the element belongs to the file itself.
using Reference = std::pair<std::function<bool(const std::string&)>, std::string>;
std::vector<Scope> copies_of(const Node& element, const Model& model, const Scene& scene,
                             const std::vector<Reference>& references, Findings& findings);

}  // namespace flexura::import::mjcf
