// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/cells/record.hpp"
#include "mesh/model/cells/rules.hpp"

namespace flexura::mesh {
namespace {

using Points = CellRecord::Points;
using Edges = std::vector<std::array<int, 2>>;
using Values = std::vector<Dual>;
using Place = std::array<Dual, 3>;

// Bedrosian's rational functions (cell.hpp).
Values functions(const CellRecord& record, const Place& x) {
  const bool linear = record.is_linear();
  const Points& node = record.nodes;
  const Dual r = x[0], s = x[1], t = x[2], rest = 1.0 - t;
  Values N;
  for (int k = 0; k < 4; ++k) {
    const double a = node(k, 0), b = node(k, 1);
    N.push_back(0.25 * ((1.0 + a * r) * (1.0 + b * s) - t + (a * b) * (r * s * t / rest)));
    if (!linear) N.back() = N.back() * (a * r + b * s - 1.0);
  }
  N.push_back(linear ? t : t * (2.0 * t - 1.0));
  if (linear) return N;
  for (int k = 5; k < 9; ++k) {  // base edges: along r where the node's s is +-1
    const bool along_r = node(k, 0) == 0;
    const Dual u = along_r ? r : s, v = along_r ? s : r;
    const double side = along_r ? node(k, 1) : node(k, 0);
    N.push_back(0.5 * (rest + u) * (rest - u) * (rest + side * v) / rest);
  }
  for (int k = 9; k < 13; ++k) {
    const double a = node(k - 9, 0), b = node(k - 9, 1);
    N.push_back(t * (rest + a * r) * (rest + b * s) / rest);
  }
  return N;
}

}  // namespace

std::vector<CellRecord> pyramids() {
  const Edges edges = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}};
  const std::vector<std::vector<int>> rings = {{0, 3, 2, 1}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const Points corners{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1}};
  const Quadrature volume = pyramid_rule(4, 5).finish();
  return {{.type = CellType::pyramid5,
           .name = "pyramid5",
           .dimension = 3,
           .shape = {5, edges, faces_of(rings, edges, 5, false)},
           .nodes = corners,
           .functions = functions,
           .volume = volume,
           .stiffness = pyramid_rule(2, 2).finish(),
           .foreign = {.gmsh = 7, .vtk = 14, .abaqus = "C3D5", .nastran = "CPYRAM"}},
          {.type = CellType::pyramid13,
           .name = "pyramid13",
           .dimension = 3,
           .shape = {5, edges, faces_of(rings, edges, 5, true)},
           .nodes = with_middles(corners, edges, 13),
           .functions = functions,
           .volume = volume,
           .stiffness = pyramid_rule(3, 3).finish(),
           .stress_points = CellType::pyramid5,
           .foreign = {.gmsh = 19,
                       .gmsh_order = {0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12},
                       .vtk = 27,
                       .nastran = "CPYRAM"}}};
}

}  // namespace flexura::mesh
