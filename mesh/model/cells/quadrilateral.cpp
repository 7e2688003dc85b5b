// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/cells/record.hpp"
#include "mesh/model/cells/rules.hpp"

namespace flexura::mesh {

std::vector<CellRecord> quadrilaterals() {
  const std::vector<std::array<int, 2>> edges = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
  const CellRecord::Points corners{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const Quadrature volume = tensor(2, 4).finish();
  return {{.type = CellType::quad4,
           .name = "quad4",
           .dimension = 2,
           .shape = {4, edges, {}},
           .nodes = corners,
           .functions = product_functions,
           .volume = volume,
           .stiffness = tensor(2, 2).finish(),
           .foreign = {.gmsh = 3, .vtk = 9, .abaqus = "S4"}},
          {.type = CellType::quad8,
           .name = "quad8",
           .dimension = 2,
           .shape = {4, edges, {}},
           .nodes = with_middles(corners, edges, 8),
           .functions = serendipity_functions,
           .volume = volume,
           .stiffness = tensor(2, 3).finish()},
          {.type = CellType::quad9,
           .name = "quad9",
           .dimension = 2,
           .shape = {4, edges, {}},
           .nodes = with_middles(corners, edges, 9),
           .functions = product_functions,
           .volume = volume,
           .stiffness = tensor(2, 3).finish()}};
}

}  // namespace flexura::mesh
