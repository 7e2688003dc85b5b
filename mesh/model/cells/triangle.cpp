// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/cells/record.hpp"
#include "mesh/model/cells/rules.hpp"

namespace flexura::mesh {
using Points = CellRecord::Points;
using Edges = std::vector<std::array<int, 2>>;

std::vector<CellRecord> triangles() {
  const Edges edges = {{0, 1}, {1, 2}, {2, 0}};
  const Points corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Quadrature volume = triangle_collapsed(4).finish();
  return {{.type = CellType::tri3,
           .name = "tri3",
           .dimension = 2,
           .shape = {3, edges, {}},
           .nodes = corners,
           .functions = simplex_functions,
           .volume = volume,
           .stiffness = triangle_symmetric(1).finish(),
           .foreign = {.gmsh = 2, .vtk = 5, .abaqus = "S3"}},
          {.type = CellType::tri6,
           .name = "tri6",
           .dimension = 2,
           .shape = {3, edges, {}},
           .nodes = with_middles(corners, edges, 6),
           .functions = simplex_functions,
           .volume = volume,
           .stiffness = triangle_symmetric(3).finish()}};
}

}  // namespace flexura::mesh
