// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/hinges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/disjoint_sets.hpp"

namespace flexura::mesh {

namespace {

// 0: one place, 1: a line, 2: more.
int spread(const Mesh& mesh, const std::vector<Index>& nodes) {
  constexpr double kInLine = 1e-6;
  const auto at = [&](Index k) -> Eigen::RowVector3d { return mesh.points.row(k); };
  Index far = nodes[0];
  for (const Index k : nodes)
    if ((at(k) - at(nodes[0])).norm() > (at(far) - at(nodes[0])).norm()) far = k;
  const Eigen::RowVector3d line = at(far) - at(nodes[0]);
  if (line.isZero(0.0)) return 0;
  return std::ranges::any_of(nodes,
                             [&](Index k) {
                               return (at(k) - at(nodes[0])).cross(line).norm() >
                                      kInLine * line.squaredNorm();
                             })
             ? 2
             : 1;
}

struct Face {
  std::array<Index, 4> corners;  // sorted, -1 first for triangles
  int cell;
};

// Cells, numbered block by block, by the faces that they share.
void join_by_faces(const Mesh& mesh, DisjointSets& groups) {
  std::vector<Face> faces;
  int number = 0;
  for (const CellBlock& block : mesh.solids)
    for (Index cell = 0; cell < block.nodes.rows(); ++cell, ++number)
      for (const CellFace& face : shape_of(block.type).faces) {
        Face entry{{-1, -1, -1, -1}, number};
        const auto n = static_cast<std::size_t>(shape_of(face.type).corners);
        for (std::size_t k = 0; k < n; ++k) entry.corners[4 - n + k] = block.nodes(cell, face.nodes[k]);
        std::ranges::sort(entry.corners);
        faces.push_back(entry);
      }
  std::ranges::sort(faces, {}, &Face::corners);
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i].corners == faces[i - 1].corners) groups.join(faces[i].cell, faces[i - 1].cell);
}

}  // namespace

std::optional<MeshHinge> find_hinge(const Mesh& mesh) {
  DisjointSets groups(static_cast<std::size_t>(mesh.n_solid_cells()));
  join_by_faces(mesh, groups);
  bool is_one = true;
  for (int k = 0; k < static_cast<int>(groups.size()) && is_one; ++k) is_one = groups.of(k) == 0;
  if (is_one) return std::nullopt;
  // The groups at each corner node that has more than one.
  std::vector<std::set<int>> at_node(static_cast<std::size_t>(mesh.n_nodes()));
  int number = 0;
  for (const CellBlock& block : mesh.solids)
    for (Index cell = 0; cell < block.nodes.rows(); ++cell, ++number)
      for (int k = 0; k < shape_of(block.type).corners; ++k)
        at_node[static_cast<std::size_t>(block.nodes(cell, k))].insert(groups.of(number));
  std::map<std::pair<int, int>, std::vector<Index>> shared;
  for (bool any = true; any;) {
    any = false;
    shared.clear();
    for (std::size_t node = 0; node < at_node.size(); ++node) {
      if (at_node[node].size() < 2) continue;
      std::set<int> now;
      for (const int group : at_node[node]) now.insert(groups.of(group));
      at_node[node] = now;
      for (auto a = now.begin(); a != now.end(); ++a)
        for (auto b = std::next(a); b != now.end(); ++b) shared[{*a, *b}].push_back(static_cast<Index>(node));
    }
    for (const auto& [pair, nodes] : shared)
      if (spread(mesh, nodes) == 2) any = groups.join(pair.first, pair.second) || any;
  }
  if (shared.empty()) return std::nullopt;
  const std::vector<Index>& nodes = shared.begin()->second;
  return MeshHinge{mesh.points.row(nodes.front()).transpose(), spread(mesh, nodes) == 1};
}

}  // namespace flexura::mesh
