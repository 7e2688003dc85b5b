// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/section_mesh.hpp"

#include <fmt/format.h>

#include <map>
#include <numeric>
#include <stdexcept>

#include "beam/section/triangle.hpp"

namespace flexura::beam {

namespace {

/// Where parts of a section touch in one point, the continuous displacement of a mesh would tie them as nothing does: the more, the
/// coarser it is.  There more than two free sides meet.
template <class Fail>
void check_corners(const SectionMesh& mesh, const Fail& fail) {
  std::vector<int> sides(static_cast<std::size_t>(mesh.points.rows()), 0), free_sides = sides;
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (int k = 3; k < 6; ++k) ++sides[mesh.triangles(cell, k)];
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (int k = 0; k < 3; ++k) {
      if (sides[mesh.triangles(cell, 3 + k)] != 1) continue;
      for (const int corner : {mesh.triangles(cell, k), mesh.triangles(cell, (k + 1) % 3)})
        if (++free_sides[corner] > 2)
          fail(
              fmt::format("parts of it touch in a single point, ({:.6g}, {:.6g}) mm; let them overlap, or "
                          "move them apart",
                          1e3 * mesh.points(corner, 0), 1e3 * mesh.points(corner, 1)));
    }
}

}  // namespace

void check_section_mesh(const std::string& name, const SectionMesh& mesh, const std::vector<Ply>& plies) {
  const auto fail = [&](const std::string& text) {
    throw std::invalid_argument(fmt::format("section \"{}\": {}", name, text));
  };
  const int n = static_cast<int>(mesh.points.rows()), m = static_cast<int>(mesh.triangles.rows());
  if (m == 0) fail("its mesh has no triangles");
  if (!mesh.points.allFinite()) fail("its mesh has points that are not finite");
  if (plies.empty()) fail("it has no material");
  if (!mesh.ply.empty() && static_cast<int>(mesh.ply.size()) != m)
    fail(fmt::format("{} plies are given for {} triangles", mesh.ply.size(), m));
  if (!mesh.plane_angle.empty() && static_cast<int>(mesh.plane_angle.size()) != m)
    fail(fmt::format("{} plane angles are given for {} triangles", mesh.plane_angle.size(), m));
  for (const int ply : mesh.ply)
    if (ply < 0 || ply >= static_cast<int>(plies.size()))
      fail(fmt::format("a triangle names material number {}; there are {}", ply, plies.size()));

  // Elements hang together by the sides that they share, each with a node at its middle.
  std::vector<int> parent(m);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int cell) {
    while (parent[cell] != cell) cell = parent[cell] = parent[parent[cell]];
    return cell;
  };
  std::vector<int> of_side(n, -1);
  std::vector<bool> used(n, false);
  for (int cell = 0; cell < m; ++cell) {
    for (int k = 0; k < 6; ++k) {
      const int node = mesh.triangles(cell, k);
      if (node < 0 || node >= n) fail(fmt::format("triangle {} names node {}; there are {}", cell, node, n));
      used[node] = true;
      if (k < 3) continue;
      if (of_side[node] < 0)
        of_side[node] = cell;
      else
        parent[root(of_side[node])] = root(cell);
    }
    for (const QuadraturePoint& q : triangle_quadrature())
      if (!(place_in(mesh, cell, q.r, q.s).det > 0.0))
        fail(fmt::format(
            "triangle {} of its mesh is turned inside out (corners must run counter-clockwise about x)",
            cell));
  }
  for (int node = 0; node < n; ++node)
    if (!used[node]) fail(fmt::format("node {} of its mesh belongs to no triangle", node));
  for (int cell = 0; cell < m; ++cell)
    if (root(cell) != root(0))
      fail("its mesh falls into separate pieces; a section must hang together by more than a corner");
  check_corners(mesh, fail);
}

std::vector<Loop> boundary_loops(const SectionMesh& mesh, std::vector<int>& nodes) {
  std::map<std::pair<int, int>, int> count;
  const auto key = [](int a, int b) { return std::pair{std::min(a, b), std::max(a, b)}; };
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (int k = 0; k < 3; ++k) ++count[key(mesh.triangles(cell, k), mesh.triangles(cell, (k + 1) % 3))];
  std::multimap<int, std::pair<int, int>> next;  // corner -> (mid-side, corner), in the triangle's own sense
  for (int cell = 0; cell < mesh.triangles.rows(); ++cell)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.triangles(cell, k), b = mesh.triangles(cell, (k + 1) % 3);
      if (count[key(a, b)] == 1) next.insert({a, {mesh.triangles(cell, 3 + k), b}});
    }
  std::vector<Loop> loops;
  while (!next.empty()) {
    std::vector<int> chain;
    auto it = next.begin();
    while (it != next.end()) {
      chain.push_back(it->first);
      chain.push_back(it->second.first);
      const int corner = it->second.second;
      next.erase(it);
      it = next.find(corner);
    }
    Loop loop(chain.size(), 2);
    for (std::size_t k = 0; k < chain.size(); ++k) loop.row(k) = mesh.points.row(chain[k]);
    loops.push_back(loop);
    nodes.insert(nodes.end(), chain.begin(), chain.end());
  }
  return loops;
}

}  // namespace flexura::beam
