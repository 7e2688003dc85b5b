// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/cells/record.hpp"
#include "mesh/model/cells/rules.hpp"

namespace flexura::mesh {
namespace {

using Points = CellRecord::Points;
using Edges = std::vector<std::array<int, 2>>;
using Values = std::vector<Dual>;
using Place = std::array<Dual, 3>;

// A triangle's functions times a line's; serendipity for the quadratic one.
Values functions(const CellRecord& record, const Place& x) {
  const Place L{1.0 - x[0] - x[1], x[0], x[1]};
  const Dual t = x[2];
  const Points& node = record.nodes;
  Values N;
  for (int k = 0; k < 6; ++k) {
    const Dual linear = L[k % 3] * 0.5 * (1.0 + node(k, 2) * t);
    N.push_back(record.is_linear()
                    ? linear
                    : linear * (2.0 * L[k % 3] - 1.0) - 0.5 * L[k % 3] * (1.0 - t) * (1.0 + t));
  }
  if (record.is_linear()) return N;
  const Edges& edges = record.shape.edges;
  for (int e = 0; e < 6; ++e)
    N.push_back(2.0 * L[edges[e][0] % 3] * L[edges[e][1] % 3] * (1.0 + node(6 + e, 2) * t));
  for (int e = 0; e < 3; ++e) N.push_back(L[e] * (1.0 - t) * (1.0 + t));
  return N;
}

}  // namespace

std::vector<CellRecord> wedges() {
  const Edges edges = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}};
  const std::vector<std::vector<int>> rings = {
      {0, 2, 1}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}};
  const Points corners{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  const Quadrature volume = triangle_times_line(triangle_collapsed(4), 4).finish();
  return {{.type = CellType::wedge6,
           .name = "wedge6",
           .dimension = 3,
           .shape = {6, edges, faces_of(rings, edges, 6, false)},
           .nodes = corners,
           .functions = functions,
           .volume = volume,
           .stiffness = triangle_times_line(triangle_symmetric(3), 2).finish(),
           .foreign = {.gmsh = 6, .vtk = 13, .abaqus = "C3D6", .nastran = "CPENTA", .unv = 112}},
          {.type = CellType::wedge15,
           .name = "wedge15",
           .dimension = 3,
           .shape = {6, edges, faces_of(rings, edges, 6, true)},
           .nodes = with_middles(corners, edges, 15),
           .functions = functions,
           .volume = volume,
           .stiffness = triangle_times_line(triangle_symmetric(7), 3).finish(),
           .stress_points = CellType::wedge6,
           .foreign = {.gmsh = 18,
                       .gmsh_order = {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11},
                       .vtk = 26,
                       .abaqus = "C3D15",
                       .nastran = "CPENTA",
                       .nastran_order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11},
                       .unv = 113,
                       .unv_order = {0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8}}}};
}

}  // namespace flexura::mesh
