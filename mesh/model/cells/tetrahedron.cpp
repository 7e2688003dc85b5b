// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "mesh/model/cells/record.hpp"
#include "mesh/model/cells/rules.hpp"

namespace flexura::mesh {

std::vector<Dual> simplex_functions(const CellRecord& record, const std::array<Dual, 3>& x) {
  const int n = record.shape.corners;
  std::vector<Dual> L(static_cast<std::size_t>(n), Dual(1.0)), N;
  for (int k = 1; k < n; ++k) {
    L[k] = x[k - 1];
    L[0] = L[0] - x[k - 1];
  }
  for (int k = 0; k < n; ++k) N.push_back(record.is_linear() ? L[k] : L[k] * (2.0 * L[k] - 1.0));
  if (!record.is_linear())
    for (const auto& edge : record.shape.edges) N.push_back(4.0 * L[edge[0]] * L[edge[1]]);
  return N;
}

std::vector<CellRecord> tetrahedra() {
  const std::vector<std::array<int, 2>> edges = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
  const std::vector<std::vector<int>> rings = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  const CellRecord::Points corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const Quadrature volume = tetrahedron14().finish();
  Rule one, four;
  one.add(0.25, 0.25, 0.25, 1. / 6);
  tetrahedron_corner_orbit(four, (5 - std::sqrt(5.)) / 20, 1. / 24);
  return {{.type = CellType::tet4,
           .name = "tet4",
           .dimension = 3,
           .shape = {4, edges, faces_of(rings, edges, 4, false)},
           .nodes = corners,
           .functions = simplex_functions,
           .volume = volume,
           .stiffness = one.finish(),
           .foreign = {.gmsh = 4, .vtk = 10, .abaqus = "C3D4", .nastran = "CTETRA", .unv = 111}},
          {.type = CellType::tet10,
           .name = "tet10",
           .dimension = 3,
           .shape = {4, edges, faces_of(rings, edges, 4, true)},
           .nodes = with_middles(corners, edges, 10),
           .functions = simplex_functions,
           .volume = volume,
           .stiffness = four.finish(),
           .stress_points = CellType::tet10,
           .foreign = {.gmsh = 11,
                       .gmsh_order = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8},
                       .vtk = 24,
                       .abaqus = "C3D10",
                       .nastran = "CTETRA",
                       .unv = 118,
                       .unv_order = {0, 2, 4, 9, 1, 3, 5, 6, 7, 8}}}};
}

}  // namespace flexura::mesh
