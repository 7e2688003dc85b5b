// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/select.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>

#include "mesh/model/geometry.hpp"
#include "mesh/model/patches.hpp"
#include "mesh/model/selecting.hpp"

namespace flexura::mesh {
namespace selecting {

using Eigen::Vector3d;

// ---- planes

static Selection select(const Context& c, const PlaneRule& rule) {
  const Vector3d normal = unit(rule.normal, "normal of the plane");
  const double tolerance = rule.tolerance > 0 ? rule.tolerance : 1e-4 * c.diagonal;
  const std::string wanted = fmt::format("plane with normal ({:.6g}, {:.6g}, {:.6g}) through {}", normal.x(),
                                         normal.y(), normal.z(), describe_point_mm(rule.point));
  if (c.cad()) {
    std::vector<const Face*> chosen;
    for (const Face& face : c.faces)
      if (face.kind == FaceKind::plane && std::abs(face.normal.dot(normal)) > std::cos(kAngle) &&
          std::abs(normal.dot(face.centroid - rule.point)) <= tolerance)
        chosen.push_back(&face);
    if (chosen.empty())
      throw std::invalid_argument(
          "no face on the " + wanted + nearest(c.faces, FaceKind::plane, [&](const Face& f) {
            return std::abs(normal.dot(f.centroid - rule.point)) +
                   c.diagonal * std::acos(std::min(1.0, std::abs(f.normal.dot(normal))));
          }));
    return select_faces(c, chosen);
  }
  Selection selection;
  double least = std::numeric_limits<double>::max();
  selection.set = set_of(pick_cells(c.mesh, [&](const CellBlock& block, Index cell, std::size_t) {
    if (std::abs(cell_normal(c.mesh, block, cell).dot(normal)) < 0.9) return false;
    double worst = 0;
    for (Eigen::Index k = 0; k < block.nodes.cols(); ++k)
      worst = std::max(
          worst, std::abs(normal.dot(c.mesh.points.row(block.nodes(cell, k)).transpose() - rule.point)));
    least = std::min(least, worst);
    return worst <= tolerance;
  }));
  if (selection.set.nodes.empty())
    throw std::invalid_argument(
        "no boundary cell lies on the " + wanted +
        (least < 1e300 ? "; the nearest that looks its way is " + mm(least) + " away" : ""));
  measure(c.mesh, selection);
  selection.description = fmt::format("{} cells on a plane", count_cells(selection.set.faces));
  return selection;
}

// ---- near a point

static Selection select(const Context& c, const NearRule& rule) {
  if (rule.radius && !(*rule.radius >= 0))
    throw std::invalid_argument(fmt::format("the search radius {} is negative", mm(*rule.radius)));
  // Without CAD faces, those of the mesh: patches between sharp edges.
  const std::vector<Index> patches =
      c.mesh.boundary_face.empty() ? find_patches(c.mesh) : std::vector<Index>();
  const std::vector<Index>& number = c.mesh.boundary_face.empty() ? patches : c.mesh.boundary_face;
  std::map<Index, double> distance;
  std::size_t k = 0;
  for (const CellBlock& block : c.mesh.boundary)
    for (Index cell = 0; cell < block.nodes.rows(); ++cell, ++k) {
      const double d = distance_to_cell(c.mesh, block, cell, rule.point);
      const auto [at, fresh] = distance.emplace(number[k], d);
      if (!fresh) at->second = std::min(at->second, d);
    }
  if (distance.empty()) throw std::invalid_argument("the mesh has no boundary cells");
  const auto best = std::min_element(distance.begin(), distance.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  std::vector<Index> chosen;
  for (const auto& [face, d] : distance)
    if (rule.radius ? d <= *rule.radius : face == best->first) chosen.push_back(face);
  const auto face_of = [&](Index n) {
    const auto found =
        std::find_if(c.faces.begin(), c.faces.end(), [&](const Face& f) { return f.number == n; });
    return found == c.faces.end() ? nullptr : &*found;
  };
  if (chosen.empty())
    throw std::invalid_argument(fmt::format(
        "no face within {} of {}; the nearest is {} away{}", mm(*rule.radius), describe_point_mm(rule.point),
        mm(best->second), face_of(best->first) ? ": " + describe(*face_of(best->first)) : ""));
  if (c.cad()) {
    std::vector<const Face*> faces;
    for (const Index n : chosen)
      if (const Face* face = face_of(n)) faces.push_back(face);
    if (!faces.empty()) {
      Selection selection = select_faces(c, faces);
      if (faces.size() == 1 && faces[0]->kind == FaceKind::cylinder)
        put_on_axis(selection, faces[0]->axis_point, faces[0]->axis);
      return selection;
    }
  }
  Selection selection;
  selection.set = set_of(pick_cells(c.mesh, [&](const CellBlock&, Index, std::size_t at) {
    return std::binary_search(chosen.begin(), chosen.end(), number[at]);
  }));
  measure(c.mesh, selection);
  selection.description =
      fmt::format("{} patches of the surface near {}", chosen.size(), describe_point_mm(rule.point));
  return selection;
}

// ---- by number and name

static Selection select(const Context& c, const FacesRule& rule) {
  if (rule.numbers.empty()) throw std::invalid_argument("no face numbers are given");
  if (!c.cad())
    throw std::invalid_argument("faces can be chosen by number on CAD parts only; this mesh has none");
  std::vector<const Face*> chosen;
  for (const Index number : rule.numbers) {
    const auto found =
        std::find_if(c.faces.begin(), c.faces.end(), [&](const Face& f) { return f.number == number; });
    if (found == c.faces.end())
      throw std::invalid_argument(
          fmt::format("there is no face {}; the part has {} faces, numbered {} to {}", number, c.faces.size(),
                      std::min_element(c.faces.begin(), c.faces.end(),
                                       [](auto& a, auto& b) { return a.number < b.number; })
                          ->number,
                      std::max_element(c.faces.begin(), c.faces.end(), [](auto& a, auto& b) {
                        return a.number < b.number;
                      })->number));
    chosen.push_back(&*found);
  }
  Selection selection = select_faces(c, chosen);
  const Face& first = *chosen.front();
  const bool one_axis = std::all_of(chosen.begin(), chosen.end(), [&](const Face* f) {
    return f->kind == FaceKind::cylinder && std::abs(f->axis.dot(first.axis)) > std::cos(kAngle) &&
           distance_to_axis(f->axis_point, first.axis_point, first.axis) < kRelative * first.radius;
  });
  if (one_axis) put_on_axis(selection, first.axis_point, first.axis);
  return selection;
}

static int edit_distance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int substituted = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

static Selection select(const Context& c, const NameRule& rule) {
  const auto found = c.mesh.sets.find(rule.name);
  if (found == c.mesh.sets.end()) {
    std::vector<std::string> names;
    for (const auto& [name, set] : c.mesh.sets) names.push_back(name);
    if (names.empty())
      throw std::invalid_argument(
          fmt::format("no face or node set is called \"{}\"; the part names none", rule.name));
    const std::string& likely =
        *std::min_element(names.begin(), names.end(), [&](const auto& a, const auto& b) {
          return edit_distance(a, rule.name) < edit_distance(b, rule.name);
        });
    if (names.size() > 10) names.resize(10);
    throw std::invalid_argument(
        fmt::format("no face or node set is called \"{}\"; did you mean \"{}\"? (there are: {})", rule.name,
                    likely, fmt::join(names, ", ")));
  }
  Selection selection;
  selection.set = found->second;
  measure(c.mesh, selection);
  for (const Face& face : c.faces)
    if (face.name == rule.name) selection.face_numbers.push_back(face.number);
  std::sort(selection.face_numbers.begin(), selection.face_numbers.end());
  selection.description = fmt::format("set \"{}\", {} node{}", rule.name, selection.set.nodes.size(),
                                      selection.set.nodes.size() == 1 ? "" : "s");
  return selection;
}

static Selection select(const Context& c, const NodesRule& rule) {
  Selection selection;
  std::vector<Index>& nodes = selection.set.nodes;
  std::map<std::int64_t, Index> index_of;
  std::map<std::int64_t, int> count;
  for (Index k = 0; k < c.mesh.n_nodes() && !rule.labels.empty(); ++k)  // points that are ours have no number
    if (const std::int64_t label =
            c.mesh.node_label.empty() ? k + 1 : c.mesh.node_label[static_cast<std::size_t>(k)];
        label >= 0)
      index_of[label] = k, ++count[label];
  for (const std::int64_t label : rule.labels) {
    const auto found = index_of.find(label);
    if (found == index_of.end())
      throw std::invalid_argument(fmt::format("there is no node {}; the mesh has {} nodes, numbered {} to {}",
                                              label, index_of.size(), index_of.begin()->first,
                                              index_of.rbegin()->first));
    if (count[label] > 1)
      throw std::invalid_argument(fmt::format(
          "{} nodes have the number {}, as instances of an assembly number theirs each from 1: choose "
          "by a named set, by = \"group\" (an instance's is called INSTANCE.SET)",
          count[label], label));
    nodes.push_back(found->second);
  }
  const double tolerance = rule.tolerance > 0 ? rule.tolerance : 1e-6 * c.diagonal;
  for (const Vector3d& point : rule.points) {
    Index best = 0;
    const double distance = (c.mesh.points.rowwise() - point.transpose()).rowwise().norm().minCoeff(&best);
    if (distance > tolerance)
      throw std::invalid_argument(fmt::format("no node within {} of {}; the nearest is {} away at {}",
                                              mm(tolerance), describe_point_mm(point), mm(distance),
                                              describe_point_mm(c.mesh.points.row(best).transpose())));
    nodes.push_back(best);
  }
  if (nodes.empty()) throw std::invalid_argument("no nodes are given");
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  selection.set.faces = pick_cells(c.mesh, [&](const CellBlock& block, Index cell, std::size_t) {
    for (Eigen::Index k = 0; k < block.nodes.cols(); ++k)
      if (!std::binary_search(nodes.begin(), nodes.end(), block.nodes(cell, k))) return false;
    return true;
  });
  // Faces give area weights only where they reach every node.
  if (set_of(selection.set.faces).nodes.size() != nodes.size()) selection.set.faces.clear();
  measure(c.mesh, selection);
  selection.description = fmt::format("{} node{}", nodes.size(), nodes.size() == 1 ? "" : "s");
  return selection;
}

}  // namespace selecting

Selection select_nodes(const Mesh& mesh, const std::vector<Face>& faces, const Rule& rule) {
  const auto box = bounding_box(mesh);
  const selecting::Context context{mesh, faces, (box.row(1) - box.row(0)).norm()};
  const auto faces_of = [&] {
    return std::visit([&](const auto& r) { return selecting::select(context, r); }, rule);
  };
  if (mesh.shells.empty()) return faces_of();
  try {
    return faces_of();
  } catch (const std::invalid_argument&) {
    if (std::optional<Selection> edges = selecting::select_edges(context, rule)) return *edges;
    throw;
  }
}

}  // namespace flexura::mesh
