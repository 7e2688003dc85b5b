// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/page/page.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mbs/base/math/rotation.hpp"
#include "mesh/page/numbered_face.hpp"

namespace flexura::import {
namespace {

view::DrawnPart part_of(const cad::Part& part, const std::string& name) {
  view::DrawnPart drawn{.name = name, .file = "parts/" + name + ".toml", .color = shown(part.color)};
  drawn.vertices = part.surface.vertices;
  drawn.edges = part.surface.edges;
  for (std::size_t f = 0; f < part.faces.size(); ++f) {
    const mesh::Face& shape = part.faces[f].shape;
    for (const Eigen::Vector3i& t : part.faces[f].triangles) {
      drawn.triangles.push_back(t);
      drawn.face.push_back(static_cast<std::int32_t>(f));
    }
    drawn.faces.push_back(mesh::numbered_face(shape));
  }
  return drawn;
}

// The file without what the page writes anew: the ground's markers, those of the bodies, the joints.
std::string head_of(Mechanism mechanism) {
  mechanism.ground.clear();
  mechanism.elements.clear();
  for (Body& body : mechanism.bodies) body.markers.clear();
  std::erase_if(mechanism.comments,
                [](const std::string& line) { return line.starts_with("degrees of freedom"); });
  return mechanism_text(mechanism);
}

}  // namespace

std::string overlap_text(const cad::Overlap& overlap, const std::string& a, const std::string& b) {
  return fmt::format("{} and {} overlap: {:.4g} mm^3, about {:.2g} mm thick, at {}", a, b,
                     1e9 * overlap.volume, 1e3 * overlap.thickness, mesh::describe_point_mm(overlap.place));
}

view::PartsPage page_of(const cad::Assembly& assembly, const cad::Built& built,
                        const std::vector<cad::Overlap>& overlaps) {
  const Mechanism& m = built.mechanism;
  view::PartsPage page{.title = shown(m.name), .created_by = "flexura import"};
  for (std::size_t p = 0; p < assembly.parts.size(); ++p) {
    const auto body = std::ranges::find(assembly.instances, static_cast<int>(p), &cad::Instance::part);
    const std::string name =
        body == assembly.instances.end()
            ? ""
            : m.bodies[static_cast<std::size_t>(body - assembly.instances.begin())].file();
    page.parts.push_back(part_of(assembly.parts[p], name));
  }
  for (std::size_t i = 0; i < m.bodies.size(); ++i) {
    const Body& body = m.bodies[i];
    page.bodies.push_back({.name = body.name,
                           .text = fmt::format("{}; {}", body.comments.at(0), body.comments.at(1)),
                           .part = assembly.instances[i].part,
                           .R_WB = body.X_WB.R,
                           .p_WB = body.X_WB.p});
  }
  page.ground = built.proposal.ground;
  for (const cad::NamedJoint& named : built.joints) {
    const cad::ProposedJoint& joint = built.proposal.joints[named.proposed];
    page.joints.push_back({.name = named.name,
                           .type = name_of(joint.form.type),
                           .lead = joint.form.lead,
                           .a = joint.a,
                           .b = joint.b,
                           .R_WJ = mbs::frame_along(joint.form.axis),
                           .p_WJ = joint.form.point,
                           .confidence = name_of(joint.confidence),
                           .doubt = joint.doubt,
                           .evidence = joint.evidence,
                           .faces = joint.faces,
                           .on = named.on});
  }
  if (!built.joints.empty() || !built.proposal.joints.empty()) page.doubts = built.proposal.doubts;
  for (const cad::NamedContact& c : built.contacts)
    page.contacts.push_back(
        {.a = c.a, .b = c.b, .place = c.place, .text = c.text.says, .lines = c.text.lines});
  for (const cad::Overlap& o : overlaps) {
    const auto name = [&](int i) { return m.bodies[static_cast<std::size_t>(i)].name; };
    page.overlaps.push_back(
        {.a = o.a, .b = o.b, .place = o.place, .text = overlap_text(o, name(o.a), name(o.b))});
  }
  page.head = head_of(m);
  return page;
}

}  // namespace flexura::import
