// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/mesh.hpp"

#include <stdexcept>

namespace flexura::mesh {
namespace {

struct TypeRow {
  CellType type;
  int nodes;
  int dimension;
  const char* name;
};

constexpr TypeRow kTypes[] = {
    {CellType::tri3, 3, 2, "tri3"},         {CellType::tri6, 6, 2, "tri6"},
    {CellType::quad4, 4, 2, "quad4"},       {CellType::quad8, 8, 2, "quad8"},
    {CellType::quad9, 9, 2, "quad9"},       {CellType::tet4, 4, 3, "tet4"},
    {CellType::tet10, 10, 3, "tet10"},      {CellType::hex8, 8, 3, "hex8"},
    {CellType::hex20, 20, 3, "hex20"},      {CellType::hex27, 27, 3, "hex27"},
    {CellType::wedge6, 6, 3, "wedge6"},     {CellType::wedge15, 15, 3, "wedge15"},
    {CellType::pyramid5, 5, 3, "pyramid5"}, {CellType::pyramid13, 13, 3, "pyramid13"},
    {CellType::line2, 2, 1, "line2"},       {CellType::line3, 3, 1, "line3"},
};

const TypeRow& row_of(CellType type) {
  for (const TypeRow& row : kTypes)
    if (row.type == type) return row;
  throw std::invalid_argument("cell type " + std::to_string(static_cast<int>(type)) + " does not exist");
}

}  // namespace

int nodes_per_cell(CellType type) {
  return row_of(type).nodes;
}
int dimension_of(CellType type) {
  return row_of(type).dimension;
}
const char* name_of(CellType type) {
  return row_of(type).name;
}

Index Mesh::n_solid_cells() const {
  Index n = 0;
  for (const CellBlock& block : solids) n += static_cast<Index>(block.nodes.rows());
  return n;
}

}  // namespace flexura::mesh
