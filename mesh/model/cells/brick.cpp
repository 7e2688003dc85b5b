// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/cells/record.hpp"
#include "mesh/model/cells/rules.hpp"

namespace flexura::mesh {

std::vector<Dual> serendipity_functions(const CellRecord& record, const std::array<Dual, 3>& x) {
  const int d = record.dimension;
  std::vector<Dual> N;
  for (Eigen::Index k = 0; k < record.nodes.rows(); ++k) {
    Dual product(1.0), sum(1.0 - d);
    for (int i = 0; i < d; ++i) {
      const double a = record.nodes(k, i);
      product = product * (a == 0 ? (1.0 - x[i]) * (1.0 + x[i]) : 0.5 * (1.0 + a * x[i]));
      sum = sum + a * x[i];
    }
    N.push_back(k < record.shape.corners ? product * sum : product);
  }
  return N;
}

std::vector<Dual> product_functions(const CellRecord& record, const std::array<Dual, 3>& x) {
  std::vector<Dual> N;
  for (Eigen::Index k = 0; k < record.nodes.rows(); ++k) {
    Dual product(1.0);
    for (int i = 0; i < record.dimension; ++i) {
      const double a = record.nodes(k, i);
      product = product * (record.is_linear() ? 0.5 * (1.0 + a * x[i]) : quadratic_line(a, x[i]));
    }
    N.push_back(product);
  }
  return N;
}

std::vector<CellRecord> bricks() {
  const std::vector<std::array<int, 2>> edges = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                                 {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  // In the order of hex27's face centres.
  const std::vector<std::vector<int>> rings = {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4},
                                               {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}};
  const CellRecord::Points corners{{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                   {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  const Quadrature volume = tensor(3, 4).finish();
  CellRecord::Points nodes27 = with_middles(corners, edges, 27);
  std::vector<CellFace> faces27 = faces_of(rings, edges, 8, true);
  for (int f = 0; f < 6; ++f) {
    nodes27(20 + f, f / 2) = f % 2 ? 1 : -1;
    faces27[static_cast<std::size_t>(f)].type = CellType::quad9;
    faces27[static_cast<std::size_t>(f)].nodes.push_back(20 + f);
  }
  return {
      {.type = CellType::hex8,
       .name = "hex8",
       .dimension = 3,
       .shape = {8, edges, faces_of(rings, edges, 8, false)},
       .nodes = corners,
       .functions = product_functions,
       .volume = volume,
       .stiffness = tensor(3, 2).finish(),
       .foreign = {.gmsh = 5, .vtk = 12, .abaqus = "C3D8", .nastran = "CHEXA", .unv = 115}},
      {.type = CellType::hex20,
       .name = "hex20",
       .dimension = 3,
       .shape = {8, edges, faces_of(rings, edges, 8, true)},
       .nodes = with_middles(corners, edges, 20),
       .functions = serendipity_functions,
       .volume = volume,
       .stiffness = tensor(3, 3).finish(),
       .stress_points = CellType::hex8,
       .foreign = {.gmsh = 17,
                   .gmsh_order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15},
                   .vtk = 25,
                   .abaqus = "C3D20",
                   .nastran = "CHEXA",
                   .nastran_order = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15},
                   .unv = 116,
                   .unv_order = {0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11}}},
      {.type = CellType::hex27,
       .name = "hex27",
       .dimension = 3,
       .shape = {8, edges, faces27},
       .nodes = nodes27,
       .functions = product_functions,
       .volume = volume,
       .stiffness = tensor(3, 3).finish(),
       .stress_points = CellType::hex8,
       .foreign = {.gmsh = 12,
                   .gmsh_order = {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18,
                                  19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26},
                   .vtk = 29,
                   .abaqus = "C3D27",
                   // The centre first, then the faces -z, +z, -y, +x, +y, -x.
                   .abaqus_order = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13,
                                    14, 15, 16, 17, 18, 19, 26, 24, 25, 22, 21, 23, 20}}}};
}

}  // namespace flexura::mesh
