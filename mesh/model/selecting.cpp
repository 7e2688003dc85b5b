// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/selecting.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <stdexcept>

#include "mesh/model/geometry.hpp"

namespace flexura::mesh::selecting {

using Eigen::Vector3d;

constexpr int kCandidates = 3;  // named when nothing fits

std::string mm(double length) {
  return fmt::format("{:.6g} mm", 1e3 * length);
}

Vector3d unit(const Vector3d& v, const char* what) {
  if (!v.allFinite() || !(v.norm() > 0))
    throw std::invalid_argument(fmt::format("the {} is (0, 0, 0); give a direction", what));
  return v.normalized();
}

double distance_to_axis(const Vector3d& p, const Vector3d& point, const Vector3d& axis) {
  return (p - point).cross(axis).norm();
}

std::vector<CellBlock> pick_cells(
    const Mesh& mesh, const std::function<bool(const CellBlock&, Index cell, std::size_t k)>& chosen) {
  std::vector<CellBlock> picked;
  std::size_t k = 0;
  for (const CellBlock& block : mesh.boundary) {
    std::vector<Index> rows;
    for (Index cell = 0; cell < block.nodes.rows(); ++cell, ++k)
      if (chosen(block, cell, k)) rows.push_back(cell);
    if (rows.empty()) continue;
    CellBlock own;
    own.type = block.type;
    own.nodes = block.nodes(rows, Eigen::all);
    picked.push_back(std::move(own));
  }
  return picked;
}

NodeSet set_of(std::vector<CellBlock> cells) {
  NodeSet set;
  for (const CellBlock& block : cells)
    set.nodes.insert(set.nodes.end(), block.nodes.data(), block.nodes.data() + block.nodes.size());
  std::sort(set.nodes.begin(), set.nodes.end());
  set.nodes.erase(std::unique(set.nodes.begin(), set.nodes.end()), set.nodes.end());
  set.faces = std::move(cells);
  return set;
}

void measure(const Mesh& mesh, Selection& selection) {
  const Surface surface = measure_surface(mesh, selection.set.faces);
  selection.area = surface.area;
  if (surface.area > 0) {
    selection.reference = surface.centroid;
    return;
  }
  selection.reference.setZero();
  for (const Index node : selection.set.nodes) selection.reference += mesh.points.row(node).transpose();
  selection.reference /= static_cast<double>(std::max<std::size_t>(1, selection.set.nodes.size()));
}

void put_on_axis(Selection& selection, const Vector3d& point, const Vector3d& axis) {
  selection.reference = point + axis * axis.dot(selection.reference - point);
}

Selection select_faces(const Context& c, std::vector<const Face*> faces) {
  Selection selection;
  for (const Face* face : faces) selection.face_numbers.push_back(face->number);
  std::sort(selection.face_numbers.begin(), selection.face_numbers.end());
  selection.set = set_of(pick_cells(c.mesh, [&](const CellBlock&, Index, std::size_t k) {
    return std::binary_search(selection.face_numbers.begin(), selection.face_numbers.end(),
                              c.mesh.boundary_face[k]);
  }));
  if (selection.set.nodes.empty())
    throw std::invalid_argument(describe(*faces.front()) +
                                ": no cell of the mesh lies on it; a smaller mesh size reaches it");
  measure(c.mesh, selection);
  // The centroid of the CAD faces, not of their mesh: interfaces of a symmetric part lie symmetric, and loops
  // close.
  double area = 0.0;
  Vector3d moment = Vector3d::Zero();
  for (const Face* face : faces) {
    area += face->area;
    moment += face->area * face->centroid;
  }
  if (area > 0.0) selection.reference = moment / area;
  selection.description = describe(*faces.front());
  if (faces.size() > 1)
    selection.description +=
        fmt::format(" and {} more: {}", faces.size() - 1, fmt::join(selection.face_numbers, ", "));
  return selection;
}

std::string nearest(const std::vector<Face>& faces, FaceKind kind,
                    const std::function<double(const Face&)>& misfit) {
  std::vector<const Face*> ordered;
  for (const Face& face : faces)
    if (face.kind == kind) ordered.push_back(&face);
  if (ordered.empty()) return fmt::format("; the part has no {}", name_of(kind));
  std::sort(ordered.begin(), ordered.end(),
            [&](const Face* a, const Face* b) { return misfit(*a) < misfit(*b); });
  std::string text = fmt::format("; nearest {}{}:", name_of(kind), ordered.size() > 1 ? "s" : "");
  for (std::size_t k = 0; k < std::min<std::size_t>(kCandidates, ordered.size()); ++k)
    text += "\n  " + describe(*ordered[k]);
  return text;
}

}  // namespace flexura::mesh::selecting
