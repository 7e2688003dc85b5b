// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "import/sdf/frames.hpp"
#include "import/tree/tree.hpp"

/// An SDF as it stands, with what it includes: frames, links and joints of all models by full names.
/// Format: sdformat.org, specification 1.4 to 1.12; older ones as far as they say the same.
namespace flexura::import::sdf {

struct Source {
  const xml::Node* element;
  std::string name, scope;  ///< full name; of the model that it is in, "arm::"
  double version;
  bool is_static;  ///< of a link: it stands
};

struct World {
  std::filesystem::path file;
  std::vector<std::unique_ptr<xml::Node>> documents;  ///< that the sources point into
  Frames frames;
  std::vector<Source> links, joints;
  std::map<std::string, std::string> canonical;  ///< "arm::" to the link that stands for the model
  Vector3d gravity = {0.0, 0.0, -9.81};
  std::string name;

  /// The full name that `name` has in this model; empty where there is nothing.
  std::string resolve(const std::string& name, const std::string& scope) const;
  /// The link that a link, frame, joint or model of this name moves with; "world", or empty where there is none.
  std::string link_of(const std::string& name, const std::string& scope) const;
};

World read_world(const std::filesystem::path& file, const std::vector<std::string>& packages,
                 Findings& findings);

/// Mass, shapes, of <link>.
tree::Link read_link(const Source& source, const std::vector<std::string>& packages, Findings& findings);

/// The joints of <joint>: two of revolute2 and universal, with a massless link between, which is added.  Links are numbered by `number`.
std::vector<tree::Joint> read_joint(const Source& source, const World& world,
                                    const std::map<std::string, int>& number, const std::vector<Pose>& X_WL,
                                    tree::Tree& tree, Findings& findings);

/// A gearbox or mimic: a weighted sum of coordinates of joints, by their places in the tree, is the offset.
struct Coupling {
  std::string name;
  std::vector<std::pair<int, double>> sum;
  double offset = 0.0;
};
std::vector<Coupling> read_couplings(const World& world, const tree::Tree& tree,
                                     const std::map<std::string, int>& number, Findings& findings);

/// Orders joints from the ground outwards; those that close loops are marked, links that nothing holds get a joint to the ground: free, or fixed.
void span(tree::Tree& tree, const std::vector<bool>& stands, const std::vector<Pose>& X_WL, bool floating);

}  // namespace flexura::import::sdf
