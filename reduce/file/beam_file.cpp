// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/file/beam_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "reduce/file/beam_curves.hpp"
#include "reduce/file/beam_loads.hpp"
#include "reduce/file/beam_sections.hpp"
#include "reduce/file/part_modes.hpp"

namespace flexura::reduce {

using input::InputError;
using input::Section;

namespace {

const std::vector<std::string> kDirections = {"x", "y", "z", "rx", "ry", "rz"};

std::bitset<6> directions(const Section& in, const std::string& key) {
  std::bitset<6> chosen;
  for (const std::string& word : in.texts(key)) {
    const auto it = std::find(kDirections.begin(), kDirections.end(), word);
    if (it == kDirections.end())
      in.refuse(key, fmt::format("\"{}\" is not a direction{}", word, input::suggestion(word, kDirections)));
    chosen[it - kDirections.begin()] = true;
  }
  return chosen;
}

// A solid's interfaces become nodes "solid.interface".
void read_solid(const std::string& name, const Section& in, const AttachSolid& attach, BeamPartInput& part,
                std::vector<std::string>& nodes) {
  SolidInput wanted{.name = name, .where = in.where()};
  if (in.has("part") == in.has("superelement"))
    throw InputError(fmt::format("{}: give either `part` or `superelement`", in.where()));
  const char* key = in.has("part") ? "part" : "superelement";
  (in.has("part") ? wanted.part : wanted.superelement) = in.file(key);
  if (!std::filesystem::exists(in.file(key)))
    in.refuse(key, "there is no such file", "relative names start at the beam part's folder");
  if (in.has("modes")) {
    if (in.has("superelement"))
      in.refuse("modes", "is for solids given as `part`", "a superelement has the modes it was made with");
    wanted.modes = in.integer("modes");
  }
  if (!attach)
    throw InputError(in.where() +
                     ": solids cannot be taken here; give them in the beam part that is reduced");
  AttachedSolid solid = attach(wanted);
  for (const ReducedInterface& interface : solid.reduction.interfaces) {
    solid.node.push_back(static_cast<int>(part.model.nodes.size()));
    part.model.anchors.push_back(solid.node.back());
    part.model.nodes.push_back({name + "." + interface.name, interface.point});
    nodes.push_back(part.model.nodes.back().name);
  }
  part.solids.push_back(std::move(solid));
}

beam::Member read_member(const std::string& name, const Section& in, const Names& nodes,
                         const Names& sections) {
  beam::Member member;
  member.name = name;
  const std::vector<std::string> ends = in.texts("nodes");
  for (int end = 0; end < 2; ++end) {
    member.end[end].node = nodes.find(in, "nodes", ends[end]);
    member.end[end].warping_free = in.flag("warping_free");
    const std::string offset = end == 0 ? "offset_1" : "offset_2",
                      release = end == 0 ? "release_1" : "release_2";
    if (in.has(offset)) member.end[end].offset_B = in.vector3(offset);
    if (in.has(release)) member.end[end].released = directions(in, release);
  }
  member.section = sections.find_or_only(in, "section");
  if (in.has("section_at_end"))
    member.section_at_end = sections.find(in, "section_at_end", in.text("section_at_end"));
  member.theory =
      in.text("theory") == "timoshenko" ? beam::Theory::timoshenko : beam::Theory::euler_bernoulli;
  if (in.has("direction") && in.has("direction_node"))
    in.refuse("direction_node", "stands beside `direction`", "keep one of the two");
  if (in.has("direction")) member.direction_B = in.vector3("direction");
  if (in.has("direction_node"))
    member.direction_node = nodes.find(in, "direction_node", in.text("direction_node"));
  if (in.has("elements")) member.elements = in.integer("elements");
  return member;
}

}  // namespace

bool is_beam_file(const std::filesystem::path& file) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string::npos) continue;
    if (line.compare(first, 8, "[member.") == 0 || line.compare(first, 8, "[curves.") == 0) return true;
  }
  return false;
}

BeamPartInput read_beam_part(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                             const AttachSolid& attach, bool run_scripts) {
  const Section in = input::read_document(file, beam_schema(), overrides);
  BeamPartInput part;
  part.name = in.title();
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  part.source = text.str();

  beam::Model& model = part.model;
  Names materials{"material", {}}, sections{"section", {}}, nodes{"node", {}};
  std::vector<beam::Material> material_list;
  if (in.has("material"))
    for (const auto& [name, m] : in.table_map("material")) {
      materials.known.push_back(name);
      material_list.push_back(read_beam_material(name, m));
    }
  for (const auto& [name, s] : in.table_map("section")) {
    sections.known.push_back(name);
    model.sections.push_back(read_beam_section(name, s, material_list, materials));
  }
  if (in.has("node"))
    for (const auto& [name, n] : in.table_map("node")) {
      nodes.known.push_back(name);
      model.nodes.push_back({name, n.vector3("position")});
    }
  if (in.has("solid"))
    for (const auto& [name, s] : in.table_map("solid")) read_solid(name, s, attach, part, nodes.known);
  if (in.has("member"))
    for (const auto& [name, m] : in.table_map("member"))
      model.members.push_back(read_member(name, m, nodes, sections));
  if (in.has("curves"))
    for (const auto& [name, c] : in.table_map("curves"))
      read_curve_members(name, c, sections, run_scripts, model);
  nodes.known.clear();
  for (const beam::Node& node : model.nodes) nodes.known.push_back(node.name);
  if (in.has("mass"))
    for (const auto& [name, m] : in.table_map("mass")) {
      beam::PointMass mass;
      mass.node = nodes.find(m, "node", m.text("node"));
      mass.mass = m.quantity("mass");
      if (m.has("center")) mass.p_NC_B = m.vector3("center");
      if (m.has("inertia")) mass.I_C_B.diagonal() = m.vector3("inertia");
      if (m.has("products")) {
        const Eigen::Vector3d p = m.vector3("products");
        mass.I_C_B(0, 1) = mass.I_C_B(1, 0) = p.x();
        mass.I_C_B(1, 2) = mass.I_C_B(2, 1) = p.y();
        mass.I_C_B(2, 0) = mass.I_C_B(0, 2) = p.z();
      }
      model.point_masses.push_back(mass);
    }
  if (in.has("link"))
    for (const auto& [name, l] : in.table_map("link")) {
      NodeLink link{.name = name};
      const std::vector<std::string> ends = l.texts("nodes");
      for (std::size_t end = 0; end < 2; ++end) link.node[end] = nodes.find(l, "nodes", ends[end]);
      if (link.node[0] == link.node[1]) l.refuse("nodes", "are two different ones");
      link.stiffness = l.quantity("stiffness");
      link.damping = l.quantity("damping");
      part.links.push_back(std::move(link));
    }
  if (in.has("load")) {
    Names members{"member", {}};
    for (const beam::Member& member : model.members) members.known.push_back(member.name);
    for (const auto& [name, l] : in.table_map("load")) {
      read_load(name, l, nodes, members, part.cases);
      if (!l.has("preload")) continue;
      const beam::Member& member =
          model.members[static_cast<std::size_t>(members.find(l, "member", l.text("member")))];
      if (member.end[0].released[0] || member.end[1].released[0])
        l.refuse("preload",
                 fmt::format("pulls on member \"{}\", an end of which slides along it", member.name),
                 "take u out of the end's releases");
    }
  }
  if (in.has("interface"))
    for (const auto& [name, i] : in.table_map("interface")) {
      BeamInterface interface {
        name, -1, { 0, 1, 2, 3, 4, 5 }
      };
      interface.node = nodes.find(i, "node", i.has("node") ? i.text("node") : name);
      if (i.has("directions")) {
        const std::bitset<6> kept = directions(i, "directions");
        interface.directions.clear();
        for (int k = 0; k < 6; ++k)
          if (kept[k]) interface.directions.push_back(k);
      }
      part.interfaces.push_back(interface);
    }
  const Section mesh = in.table("mesh");
  part.subdivision.elements_per_member = mesh.integer("elements");
  if (mesh.has("size")) part.subdivision.max_length = mesh.quantity("size");
  if (mesh.has("frequency")) part.subdivision.max_frequency_hz = mesh.quantity("frequency");
  part.subdivision.frequency_error = mesh.quantity("frequency_error");
  read_request(in, part);
  part.recovery = read_recovery(in.table("recovery"));
  try {
    beam::check(model);
  } catch (const std::invalid_argument& error) {
    throw InputError(file.string() + ": " + error.what());
  }
  return part;
}

}  // namespace flexura::reduce
