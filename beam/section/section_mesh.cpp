// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/section_mesh.hpp"

#include <fmt/format.h>

#include <map>
#include <numeric>
#include <stdexcept>

#include "beam/section/triangle.hpp"

namespace flexura::beam {

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

  std::vector<int> parent(n);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  std::vector<bool> used(n, false);
  for (int cell = 0; cell < m; ++cell) {
    for (int k = 0; k < 6; ++k) {
      const int node = mesh.triangles(cell, k);
      if (node < 0 || node >= n) fail(fmt::format("triangle {} names node {}; there are {}", cell, node, n));
      used[node] = true;
      parent[root(node)] = root(mesh.triangles(cell, 0));
    }
    for (const QuadraturePoint& q : triangle_quadrature())
      if (!(place_in(mesh, cell, q.r, q.s).det > 0.0))
        fail(fmt::format(
            "triangle {} of its mesh is turned inside out (corners must run counter-clockwise about x)",
            cell));
  }
  const int first = root(mesh.triangles(0, 0));
  for (int node = 0; node < n; ++node) {
    if (!used[node]) fail(fmt::format("node {} of its mesh belongs to no triangle", node));
    if (root(node) != first) fail("its mesh falls into separate pieces; a section must hang together");
  }
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
