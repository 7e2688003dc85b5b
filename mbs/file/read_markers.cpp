// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/read_markers.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mbs/file/bodies/read_pose.hpp"
#include "mbs/file/read_linked_marker.hpp"

namespace flexura::mbs {

using input::Section;

namespace {

// The node of the body that carries the marker, and where it is; -1 where none does.
std::pair<int, Vector3d> carrying_node(ReadModel& model, const Section& m, int body, const std::string& name,
                                       bool deforms, const superelement::Superelement* se) {
  const auto& interfaces = model.interfaces[body];
  if (const char* key = linking_key(m)) {
    if (!se) m.refuse(key, "only superelements have nodes to follow", "take the key away, or use on");
    std::vector<BodyNode>& linked = model.linked[body];
    BodyNode node = read_linked_node(m, name, *se, deforms, model.notes);
    if (m.text("link") == "rigid")
      model.blind_spots.push_back({.kind = "link", .name = name, .remedy = "", .has_own_frame = true});
    const Vector3d p = node.p_BoN_B;
    if (!deforms) return {-1, p};
    linked.push_back(std::move(node));
    return {static_cast<int>(interfaces.size() + linked.size()) - 1, p};
  }
  const std::string interface = m.text("on");
  const auto found =
      std::ranges::find_if(interfaces, [&](const auto& entry) { return entry.first == interface; });
  if (found == interfaces.end()) {
    std::vector<std::string> known;
    for (const auto& entry : interfaces) known.push_back(entry.first);
    m.refuse(
        "on",
        fmt::format("the body has no interface \"{}\"{}", interface, input::suggestion(interface, known)),
        interfaces.empty() ? "only superelements have interfaces" : "");
  }
  return {deforms ? static_cast<int>(found - interfaces.begin()) : -1, found->second};
}

}  // namespace

std::pair<int, Pose> undeformed_place(const ReadModel& model, int marker) {
  const MechanismDescription& d = model.description;
  const MarkerDescription& m = d.markers[static_cast<std::size_t>(marker)];
  for (const auto& [root, chain] : model.segments)
    for (std::size_t k = 0; k < chain.bodies.size(); ++k) {
      if (chain.bodies[k] != m.body) continue;
      const Pose X = d.undeformed(marker);
      return {root, {X.R, chain.origins_B[k] + X.p}};
    }
  if (m.node < 0 || !model.to_prepare.contains(m.body)) return {m.body, d.undeformed(marker)};
  const auto& interfaces = model.interfaces.at(m.body);
  const auto node = static_cast<std::size_t>(m.node);
  const Vector3d p = node < interfaces.size() ? interfaces[node].second
                                              : model.linked.at(m.body)[node - interfaces.size()].p_BoN_B;
  return {m.body, {m.X_BP.R, p + m.X_BP.p}};
}

void add_marker(ReadModel& model, int body, const std::string& full_name, const Pose& X, int node,
                const Vector3d& carried_at) {
  MechanismDescription& d = model.description;
  if (const auto found = model.segments.find(body); found != model.segments.end()) {
    if (!found->second.seats.empty()) {  // of elements; what is on no station is fixed to the root's section
      const Segments::Seat seat =
          node < 0 ? Segments::Seat{body, -1} : found->second.seats[static_cast<std::size_t>(node)];
      d.markers.push_back({full_name, seat.body, {X.R, seat.p + X.p}, seat.node});
      return;
    }
    const int piece = found->second.piece_at(carried_at);
    d.markers.push_back(
        {full_name, found->second.bodies[piece], {X.R, X.p - found->second.origins_B[piece]}, -1});
    return;
  }
  d.markers.push_back({full_name, body, X, node});
}

void read_markers(ReadModel& model, const Section& s, int body, const Pose& X_B, const std::string& owner,
                  bool deforms, const superelement::Superelement* se) {
  const MechanismDescription& d = model.description;
  for (const auto& [own_name, m] : s.table_map("marker")) {
    Pose X = read_pose(m);
    const std::string name = owner + "." + own_name;
    int node = -1;
    Vector3d carried_at = X.p;  // of the undeformed body
    for (const MarkerDescription& other : d.markers)
      if (other.name == name)
        m.refuse("",
                 se ? "has the name of an interface of the superelement"
                    : "has the name of an end or a point of the beam, which is a marker already",
                 "choose another name");
    for (const char* key : {"weights", "link"})
      if (m.has(key) && !linking_key(m))
        m.refuse(key, "is for a marker on several nodes", "say which by nodes, points or within");
    if (m.has("on") || linking_key(m)) {
      const auto [carries, p] = carrying_node(model, m, body, name, deforms, se);
      node = carries;
      if (!m.has("position")) X.p = p;
      carried_at = p;
      if (node >= 0) X.p -= p;  // relative to the node
    } else if (deforms && d.bodies[static_cast<std::size_t>(body)].of_beam) {
      // As of a beam of elements: fixed to the section at its root.
      node = 0;
      carried_at = model.interfaces[body].front().second;
      X.p -= carried_at;
    } else if (deforms) {
      model.notes.push_back(
          fmt::format("marker \"{}\" is fixed in the body's floating frame and sees no deformation; "
                      "say on = \"INTERFACE\" (or nodes, points, within) to let the body carry it",
                      name));
    }
    add_marker(model, body, name, X_B * X, node, X_B * carried_at);
  }
}

}  // namespace flexura::mbs
