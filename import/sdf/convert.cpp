// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/sdf/convert.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "import/sdf/reader.hpp"
#include "import/tree/writer.hpp"

namespace flexura::import::sdf {
namespace {

// <gravity> of a link: without it its weight is held up.
void hold_up(const World& world, const tree::Tree& tree, tree::Writer& writer) {
  for (std::size_t l = 0; l < world.links.size(); ++l) {
    const xml::Node* const gravity = world.links[l].element->child("gravity");
    if (world.links[l].is_static || gravity == nullptr || (gravity->text != "0" && gravity->text != "false"))
      continue;
    const tree::Inertial& inertial = tree.links[l].inertial;
    const std::string name = writer.body(static_cast<int>(l)) + "_weightless";
    std::vector<Line> lines = {
        {"type", toml(std::string("force"))},
        {"marker", toml(writer.marker(static_cast<int>(l), name, {Matrix3d::Identity(), inertial.center}))}};
    for (int k = 0; k < 3; ++k)
      if (const double f = -inertial.mass * tree.gravity[k]; f != 0.0)
        lines.emplace_back(std::string(1, "xyz"[k]), toml(f));
    if (lines.size() > 2) writer.add("force", name, {"gravity does not act on this link in the file"}, lines);
  }
}

void couple(const std::vector<Coupling>& couplings, tree::Writer& writer) {
  for (const Coupling& c : couplings) {
    std::string joints, factors;
    for (const auto& [j, factor] : c.sum) {
      joints += (joints.empty() ? "[" : ", ") + toml(writer.joint(j));
      factors += (factors.empty() ? "[" : ", ") + toml(factor);
    }
    writer.add("constraint", c.name, {},
               {{"type", toml(std::string("coupler"))},
                {"joints", joints + "]"},
                {"factors", factors + "]"},
                {"offset", toml(c.offset)}});
  }
}

}  // namespace

Mechanism to_mechanism(const std::filesystem::path& file, const Choices& choices, Findings& findings) {
  const World world = read_world(file, choices.packages, findings);
  tree::Tree tree;
  tree.name = world.name.empty() ? file.stem().string() : world.name;
  tree.gravity = world.gravity;
  tree.comments = {
      "imported by flexura import from " + shown(file.filename().string()),
      "Bodies have the frames of the links; coordinates of joints are 0 as the file places them."};
  std::map<std::string, int> number;
  std::vector<Pose> X_WL;
  std::vector<bool> stands;
  for (const Source& source : world.links) {
    number[source.name] = static_cast<int>(tree.links.size());
    tree.links.push_back(read_link(source, choices.packages, findings));
    stands.push_back(source.is_static);
    X_WL.emplace_back();
    try {
      X_WL.back() = world.frames.in_world(source.name);
    } catch (const std::invalid_argument& why) {
      xml::fault(findings, *source.element, fmt::format("link \"{}\": {}", shown(source.name), why.what()));
    }
  }
  if (tree.links.empty()) findings.fault("has no <link>: there is nothing that could move");
  for (const Source& source : world.joints)
    for (tree::Joint& joint : read_joint(source, world, number, X_WL, tree, findings)) {
      if (!choices.stops) joint.lower = joint.upper = std::nullopt;
      tree.joints.push_back(std::move(joint));
    }
  findings.require_no_fault();
  while (X_WL.size() < tree.links.size()) {  // crosses of joints of two axes, reached by their joints
    X_WL.emplace_back();
    stands.push_back(false);
  }
  span(tree, stands, X_WL, choices.floating);
  const std::vector<Coupling> couplings = read_couplings(world, tree, number, findings);
  const tree::StartMass mass(tree);
  mass.require_inertia(findings);
  findings.require_no_fault();
  tree::Writer writer(tree, mass, findings);
  hold_up(world, tree, writer);
  couple(couplings, writer);
  return writer.take();
}

}  // namespace flexura::import::sdf
