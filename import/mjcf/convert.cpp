// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/mjcf/convert.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "import/mjcf/sections.hpp"

namespace flexura::import::mjcf {
namespace {

// springdamper: stiffness and damping by the inertia that the joint has at the start (MuJoCo's AutoSpringDamper).
void set_springs_by_time(Scene& scene, const tree::StartMass& mass) {
  for (const auto& [j, info] : scene.joint_infos) {
    if (!(info.spring_time > 0.0) || !(info.spring_damping_ratio > 0.0)) continue;
    tree::Joint& joint = scene.tree.joints[static_cast<std::size_t>(j)];
    double compliance = 0.0;
    for (int k = 0; k < joint.freedoms(); ++k) compliance += mass.compliance({{mass.first(j) + k, 1.0}});
    if (!(compliance > 0.0)) continue;
    const double inertia = joint.freedoms() / compliance, time = info.spring_time,
                 ratio = info.spring_damping_ratio;
    joint.stiffness = inertia / (time * time * ratio * ratio);
    joint.damping = 2.0 * inertia / time;
  }
}

void add_gravity_compensation(const Scene& scene, tree::Writer& writer) {
  const tree::Tree& tree = scene.tree;
  for (std::size_t l = 0; l < tree.links.size(); ++l) {
    const double share = scene.gravity_compensation[l];
    const tree::Inertial& inertial = tree.links[l].inertial;
    if (share == 0.0 || !(inertial.mass > 0.0) || tree.gravity.isZero(0.0)) continue;
    const std::string name = writer.body(static_cast<int>(l)) + "_gravcomp";
    std::vector<Line> lines = {
        {"type", toml(std::string("force"))},
        {"marker", toml(writer.marker(static_cast<int>(l), name, {Matrix3d::Identity(), inertial.center}))}};
    for (int k = 0; k < 3; ++k)
      if (const double f = -share * inertial.mass * tree.gravity[k]; f != 0.0)
        lines.emplace_back(std::string(1, "xyz"[k]), toml(f));
    writer.add("force", name, {fmt::format("gravcomp {}", share)}, lines);
  }
}

void note_passed_over(const Model& model, const Scene& scene, Findings& findings) {
  std::map<std::string, int> others = scene.passed_over;
  const int touching = others.contains("contact") ? others.at("contact") : 0;
  others.erase("contact");
  for (const Node& section : model.root.children) {
    if (section.tag == "sensor") others["sensor"] += static_cast<int>(section.children.size());
    if (section.tag == "contact")
      others["contact pair or exclusion"] += static_cast<int>(section.children.size());
  }
  if (touching > 0)
    findings.note(
        "contacts left out",
        fmt::format(
            "contact of {} geoms is not taken over: bodies pass through each other and the ground, "
            "[force.NAME] type = \"contact\" or \"surface_contact\" of the mechanism file makes them touch",
            touching));
  std::string list;
  for (const auto& [what, n] : others) list += fmt::format("{}{} {}", list.empty() ? "" : ", ", n, what);
  if (!list.empty()) findings.note("lists of what has no part in the motion", "passed over: " + list);
}

void refuse_deformables(const Model& model, Findings& findings) {
  for (const Node* section : model.sections("deformable"))
    for (const Node* flex : section->all("flex"))
      xml::fault(findings, *flex,
                 fmt::format("<flex> (\"{}\"): bodies that deform are not read", shown(flex->get("name"))));
}

}  // namespace

Mechanism to_mechanism(const std::filesystem::path& file, const Choices& choices, Findings& findings) {
  const std::shared_ptr<Model> model = read_model(file, findings);
  if (!choices.stops) model->option.limits = false;
  Scene scene = read_scene(*model, findings);
  refuse_deformables(*model, findings);
  tree::Tree& tree = scene.tree;
  tree.name = model->root.get("model", file.stem().string());
  tree.file = file.string();
  tree.gravity = model->option.gravity;
  tree.comments = {"imported by flexura import from " + shown(file.filename().string()),
                   "Bodies have the frames of the file's; coordinates of joints are MuJoCo's qpos."};
  findings.require_no_fault();
  if (tree.links.empty())
    findings.fault(fmt::format("has no <body>: there is nothing that could move{}",
                               model->missing_include.empty() ? ""
                                                              : "; \"" + shown(model->missing_include) +
                                                                    "\", which it includes, is not there"));
  findings.require_no_fault();
  {
    const tree::StartMass mass(tree);
    mass.require_inertia(findings);
    set_springs_by_time(scene, mass);
  }
  findings.require_no_fault();
  const tree::StartMass mass(tree);
  tree::Writer writer(tree, mass, findings);
  add_gravity_compensation(scene, writer);
  add_fluid(scene, writer, findings);
  const Tendons tendons = add_tendons(scene, writer, findings);
  if (model->option.equality) add_equalities(scene, tendons, writer, findings);
  if (model->option.actuation) add_actuators(scene, tendons, writer, findings);
  add_keyframes(scene, writer, findings);
  findings.require_no_fault();
  note_passed_over(*model, scene, findings);
  return writer.take();
}

}  // namespace flexura::import::mjcf
