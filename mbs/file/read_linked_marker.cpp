// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/read_linked_marker.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace flexura::mbs {
namespace {

using input::Section;
namespace dim = input::dim;

int find_interface(const Section& m, const superelement::Superelement& se, const std::string& name) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < se.interfaces.size(); ++i) {
    if (se.interfaces[i].name == name) return static_cast<int>(i);
    known.push_back(se.interfaces[i].name);
  }
  m.refuse("nodes", fmt::format("the body has no interface \"{}\"{}", name, input::suggestion(name, known)));
}

/// The vertex of the surface nearest to the point, and how far it is.
std::pair<int, double> nearest_vertex(const superelement::Superelement& se, const Vector3d& point) {
  Eigen::Index v = 0;
  const double square =
      (se.surface.vertices.rowwise() - point.transpose()).rowwise().squaredNorm().minCoeff(&v);
  return {static_cast<int>(v), std::sqrt(square)};
}

void add_surface_nodes(const Section& m, const std::string& name, const superelement::Superelement& se,
                       NodePlaces& places, std::vector<std::string>& notes) {
  double farthest = 0.0;
  for (const Vector3d& point : m.vectors3("points")) {
    const auto [v, distance] = nearest_vertex(se, point);
    if (std::ranges::find(places.vertices, v) != places.vertices.end())
      m.refuse("points",
               fmt::format("[{:.6g}, {:.6g}, {:.6g}] m is nearest to the same node of the surface as a point "
                           "before it",
                           point.x(), point.y(), point.z()),
               "move the points apart, or mesh the part finer");
    places.vertices.push_back(v);
    farthest = std::max(farthest, distance);
  }
  if (m.has("within")) {
    const double radius = m.quantity("within");
    const Vector3d at = m.vector3("position");
    for (Eigen::Index v = 0; v < se.surface.vertices.rows(); ++v)
      if ((se.surface.vertices.row(v).transpose() - at).norm() <= radius)
        places.vertices.push_back(static_cast<int>(v));
    if (places.vertices.size() < 3)
      m.refuse("within",
               fmt::format("the sphere holds {} nodes of the surface, the nearest one lies {:.4g} m from "
                           "position; three are needed at least",
                           places.vertices.size(), nearest_vertex(se, at).second),
               "give a larger radius, or mesh the part finer");
    notes.push_back(
        fmt::format("marker \"{}\" follows {} nodes of the surface", name, places.vertices.size()));
  } else {
    notes.push_back(
        fmt::format("marker \"{}\" follows {} nodes of the surface, the farthest {:.3g} mm from its point",
                    name, places.vertices.size(), 1e3 * farthest));
  }
}

}  // namespace

std::vector<input::Key> linked_marker_keys() {
  using namespace input;
  return {
      texts("nodes",
            "instead of on: several interfaces, in a superelement, that carry the marker together; without a "
            "position it stands in their centre"),
      vectors3(
          "points", dim::length,
          "instead of on: places on the surface of a superelement with pictures, in the body's frame; the "
          "nodes nearest to "
          "them carry the marker, beside those of nodes; loads on it have no geometric stiffening in the "
          "superelement, so modal-stiffened refuses them. A single point takes the displacement of its node "
          "alone and turns "
          "with the body's frame: for forces and positions"),
      quantity("within", dim::length,
               "instead of on: all nodes of the surface that lie so near to position carry the marker")
          .above(0.0),
      quantities("weights", dim::none, "of nodes, then of points; without it all equal"),
      choice("link", {"average", "rigid", "beam"},
             "how several nodes carry the marker: average (interpolation, RBE3): it moves by their mean and "
             "turns by the rotation that fits their displacements best, and its loads spread over them as "
             "forces, the body as soft as it is; rigid (RBE2): the interfaces in nodes move as one rigid "
             "piece, the body is stiffer by that; beam: the marker sits at its position between two "
             "interfaces of a "
             "straight beam and moves by the shape functions of its element, stretch and twist linear, "
             "across it cubic, "
             "which is exact of an Euler-Bernoulli beam that no load bends between them (what shear deflects "
             "it by is "
             "shared out as bending is)")
          .or_default("average"),
  };
}

const char* linking_key(const Section& m) {
  for (const char* key : {"nodes", "points", "within"})
    if (m.has(key)) return key;
  return nullptr;
}

bool follows_surface(const Section& m) {
  return m.has("points") || m.has("within");
}

bool a_marker_follows_surface(const Section& body) {
  return std::ranges::any_of(body.table_map("marker"),
                             [](const auto& entry) { return follows_surface(entry.second); });
}

BodyNode read_linked_node(const Section& m, const std::string& name, const superelement::Superelement& se,
                          bool deforms, std::vector<std::string>& notes) {
  if (m.has("on")) m.refuse("on", "is for a marker on one interface", "keep on, or what names several nodes");
  if (m.has("within")) {
    for (const char* key : {"nodes", "points", "weights"})
      if (m.has(key))
        m.refuse(key, "does not go with within, which takes all nodes around", "keep one of them");
    if (!m.has("position"))
      m.refuse("within", "needs a position to be near to", "give the marker a position");
  }
  NodePlaces places;
  for (const std::string& interface : m.texts("nodes")) {
    const int i = find_interface(m, se, interface);
    if (std::ranges::find(places.interfaces, i) != places.interfaces.end())
      m.refuse("nodes", fmt::format("names \"{}\" twice", interface), "name each interface once");
    places.interfaces.push_back(i);
  }
  const bool is_rigid = m.text("link") == "rigid", is_beam = m.text("link") == "beam";
  if (is_beam &&
      (places.interfaces.size() != 2 || follows_surface(m) || m.has("weights") || !m.has("position")))
    m.refuse("link", "a beam is two interfaces, and the marker has a position between them",
             "give nodes = [\"A\", \"B\"] and position alone");
  if (follows_surface(m)) {
    const char* key = m.has("points") ? "points" : "within";
    if (is_rigid)
      m.refuse("link", "a rigid link joins interfaces; nodes of the surface inside the body would lock modes",
               fmt::format("tie these nodes when the part is reduced ([interface.NAME] tie = \"rigid\"), or "
                           "use link = \"average\""));
    if (se.surface.vertices.rows() == 0 || (deforms && se.shapes.rows() != 3 * se.surface.vertices.rows()))
      m.refuse(key, "the superelement has no shapes on its surface",
               "reduce the part from its CAD file, mesh or beams (foreign matrices bring none), or name "
               "interfaces in nodes");
    add_surface_nodes(m, name, se, places, notes);
  }
  if (m.has("weights")) {
    places.weights = m.quantities("weights");
    const std::size_t n = places.interfaces.size() + places.vertices.size();
    if (is_rigid) m.refuse("weights", "a rigid link has none", "take the key away");
    if (places.weights.size() != n)
      m.refuse("weights", fmt::format("has {} entries for {} nodes", places.weights.size(), n),
               "give one weight for each");
    if (std::ranges::any_of(places.weights, [](double w) { return !(w > 0.0); }))
      m.refuse("weights", "a weight must be positive", "leave out nodes that shall not count");
  }
  if (places.interfaces.empty() && places.vertices.empty())
    m.refuse(linking_key(m), "names no node", "name some, or take the key away");
  try {
    BodyNode node;
    if (!deforms)
      node = {name, centre_of(se, places), {}};
    else if (is_beam)
      node = beam_node(se, name, places.interfaces[0], places.interfaces[1], m.vector3("position"));
    else if (places.interfaces.empty() && places.vertices.size() == 1)
      node = surface_node(se, name, places.vertices[0]);
    else if (is_rigid)
      node = rigidly_linked_node(se, name, places.interfaces);
    else
      node = interpolated_node(se, name, places);
    return node;
  } catch (const std::invalid_argument& error) {
    m.refuse(linking_key(m), error.what());
  }
}

}  // namespace flexura::mbs
