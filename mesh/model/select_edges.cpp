// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "mesh/model/selecting.hpp"

namespace flexura::mesh::selecting {

using Eigen::Vector3d;

namespace {

using Edge = std::pair<Index, Index>;

// Edges that one shell alone has.
std::vector<Edge> free_edges(const Mesh& mesh) {
  std::map<Edge, int> uses;
  for (const CellBlock& block : mesh.shells)
    for (Eigen::Index cell = 0; cell < block.nodes.rows(); ++cell)
      for (Eigen::Index a = 0; a < block.nodes.cols(); ++a)
        ++uses[std::minmax({block.nodes(cell, a), block.nodes(cell, (a + 1) % block.nodes.cols())})];
  std::vector<Edge> free;
  for (const auto& [edge, count] : uses)
    if (count == 1) free.push_back(edge);
  return free;
}

template <class Lies>
std::optional<Selection> edges_that(const Mesh& mesh, const Lies& lies) {
  Selection selection;
  double length = 0.0;
  int count = 0;
  Vector3d moment = Vector3d::Zero();
  for (const auto& [a, b] : free_edges(mesh)) {
    const Vector3d x = mesh.points.row(a), y = mesh.points.row(b);
    if (!lies(x) || !lies(y)) continue;
    ++count;
    length += (y - x).norm();
    moment += 0.5 * (y - x).norm() * (x + y);
    selection.set.nodes.insert(selection.set.nodes.end(), {a, b});
  }
  if (count == 0) return {};
  std::ranges::sort(selection.set.nodes);
  selection.set.nodes.erase(std::unique(selection.set.nodes.begin(), selection.set.nodes.end()),
                            selection.set.nodes.end());
  selection.reference = moment / length;
  selection.description = fmt::format("{} edges of shells, {} long", count, mm(length));
  return selection;
}

std::optional<Selection> of(const Context& c, const PlaneRule& rule) {
  const Vector3d normal = unit(rule.normal, "normal of the plane");
  const double tolerance = rule.tolerance > 0 ? rule.tolerance : 1e-4 * c.diagonal;
  return edges_that(c.mesh,
                    [&](const Vector3d& x) { return std::abs(normal.dot(x - rule.point)) <= tolerance; });
}

std::optional<Selection> of(const Context& c, const CylinderRule& rule) {
  if (!rule.radius) return {};
  const Vector3d axis = unit(rule.direction, "axis");
  const double tolerance = rule.tolerance > 0 ? rule.tolerance : kRelative * *rule.radius;
  std::optional<Selection> found = edges_that(c.mesh, [&](const Vector3d& x) {
    const double along = axis.dot(x - rule.point);
    if (rule.extent && (along < (*rule.extent)[0] - tolerance || along > (*rule.extent)[1] + tolerance))
      return false;
    return std::abs(distance_to_axis(x, rule.point, axis) - *rule.radius) <= tolerance;
  });
  if (found) put_on_axis(*found, rule.point, axis);
  return found;
}

std::optional<Selection> of(const Context&, const auto&) {
  return {};
}

}  // namespace

std::optional<Selection> select_edges(const Context& c, const Rule& rule) {
  return std::visit([&](const auto& r) { return of(c, r); }, rule);
}

}  // namespace flexura::mesh::selecting
