// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/sharp_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace flexura::reduce {

using Eigen::Index;
using Eigen::Vector3d;

namespace {

/// Outward normal of a surface cell at the middle of its edge, and that of the cell's centre.
struct EdgeSide {
  Vector3d normal, middle, centre;
  bool held = false;  ///< by a rigid interface, all of its nodes
};

EdgeSide side_of(const mesh::Mesh& mesh, const mesh::CellBlock& block, Index row, int edge) {
  const mesh::CellShape& shape = mesh::shape_of(block.type);
  static const double square[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}},
                      triangle[3][2] = {{0, 0}, {1, 0}, {0, 1}};
  const auto corner = [&](int a) -> const double* { return shape.corners == 4 ? square[a] : triangle[a]; };
  const double *from = corner(shape.edges[edge][0]), *to = corner(shape.edges[edge][1]);
  const auto values =
      mesh::evaluate_shape(block.type, {0.5 * (from[0] + to[0]), 0.5 * (from[1] + to[1]), 0.0});
  EdgeSide out{Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()};
  Vector3d along_r = Vector3d::Zero(), along_s = along_r;
  for (Index a = 0; a < block.nodes.cols(); ++a) {
    const Vector3d x = mesh.points.row(block.nodes(row, a));
    along_r += values.dN(a, 0) * x;
    along_s += values.dN(a, 1) * x;
    out.middle += values.N(a) * x;
    if (a < shape.corners) out.centre += x / shape.corners;
  }
  out.normal = along_r.cross(along_s).normalized();
  return out;
}

}  // namespace

bool is_concentrated(const Part& part, const InterfaceSpec& interface) {
  if (part.mesh.solids.empty() || interface.set.nodes.empty()) return false;
  if (interface.tie == Tie::node) return true;
  // Nodes on a line: their distances from the line through the first and the one farthest from it.
  constexpr double kOnLine = 1e-6;  // of its length: digits of mesh files
  const auto at = [&](mesh::Index node) -> Vector3d { return part.mesh.points.row(node).transpose(); };
  const Vector3d first = at(interface.set.nodes.front());
  Vector3d along = Vector3d::Zero();
  for (const mesh::Index node : interface.set.nodes)
    if ((at(node) - first).squaredNorm() > along.squaredNorm()) along = at(node) - first;
  const double length = along.norm();
  return std::all_of(interface.set.nodes.begin(), interface.set.nodes.end(), [&](mesh::Index node) {
    return (at(node) - first).cross(along).norm() <= kOnLine * length * length;
  });
}

std::vector<SharpEdge> sharp_edges(const Part& part) {
  constexpr double kSharp = 25.0 * std::numbers::pi / 180.0;
  const mesh::Mesh& mesh = part.mesh;
  std::vector<char> held(static_cast<std::size_t>(mesh.n_nodes()), 0);
  std::vector<SharpEdge> sharp(held.size(), SharpEdge::none);
  for (const InterfaceSpec& interface : part.interfaces)
    if (interface.tie == Tie::rigid)
      for (const mesh::Index node : interface.set.nodes) held[static_cast<std::size_t>(node)] = 1;
  std::map<std::array<mesh::Index, 2>, EdgeSide> open;
  for (const mesh::CellBlock& block : mesh.boundary) {
    const mesh::CellShape& shape = mesh::shape_of(block.type);
    for (Index row = 0; row < block.nodes.rows(); ++row) {
      bool all_held = true;
      for (const mesh::Index node : block.nodes.row(row))
        all_held = all_held && held[static_cast<std::size_t>(node)];
      for (int e = 0; e < static_cast<int>(shape.edges.size()); ++e) {
        std::array<mesh::Index, 2> ends{block.nodes(row, shape.edges[e][0]),
                                        block.nodes(row, shape.edges[e][1])};
        std::sort(ends.begin(), ends.end());
        EdgeSide side = side_of(mesh, block, row, e);
        side.held = all_held;
        const auto [other, first] = open.emplace(ends, side);
        if (first) continue;
        const EdgeSide& there = other->second;
        const bool turns = std::acos(std::clamp(side.normal.dot(there.normal), -1.0, 1.0)) > kSharp;
        const bool inwards = there.normal.dot(side.centre - there.middle) > 0.0;
        const SharpEdge kind = turns && inwards          ? SharpEdge::reentrant
                               : side.held != there.held ? SharpEdge::held
                                                         : SharpEdge::none;
        if (kind != SharpEdge::none)
          for (const mesh::Index node : ends) {
            SharpEdge& of = sharp[static_cast<std::size_t>(node)];
            if (of != SharpEdge::reentrant) of = kind;  // the stronger one
          }
        open.erase(other);
      }
    }
  }
  for (const InterfaceSpec& interface : part.interfaces)
    if (is_concentrated(part, interface))
      for (const mesh::Index node : interface.set.nodes)
        sharp[static_cast<std::size_t>(node)] = SharpEdge::concentrated;
  return sharp;
}

std::vector<char> nodes_at_sharp_edges(const Part& part) {
  std::vector<char> out;
  for (const SharpEdge kind : sharp_edges(part)) out.push_back(kind != SharpEdge::none);
  return out;
}

}  // namespace flexura::reduce
