// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/cells/record.hpp"
#include "mesh/model/cells/rules.hpp"

namespace flexura::mesh {
namespace {

using Points = CellRecord::Points;
using Edges = std::vector<std::array<int, 2>>;
using Values = std::vector<Dual>;
using Place = std::array<Dual, 3>;

Values functions(const CellRecord& record, const Place& x) {
  Values N;
  for (const double a : record.nodes.col(0))
    N.push_back(record.is_linear() ? 0.5 * (1.0 + a * x[0]) : quadratic_line(a, x[0]));
  return N;
}

}  // namespace

std::vector<CellRecord> lines() {
  const Edges edges = {{0, 1}};
  const Points corners{{-1, 0, 0}, {1, 0, 0}};
  const Quadrature volume = tensor(1, 4).finish();
  return {{.type = CellType::line2,
           .name = "line2",
           .dimension = 1,
           .shape = {2, edges, {}},
           .nodes = corners,
           .functions = functions,
           .volume = volume,
           .stiffness = tensor(1, 1).finish()},
          {.type = CellType::line3,
           .name = "line3",
           .dimension = 1,
           .shape = {2, edges, {}},
           .nodes = with_middles(corners, edges, 3),
           .functions = functions,
           .volume = volume,
           .stiffness = tensor(1, 2).finish()}};
}

}  // namespace flexura::mesh
