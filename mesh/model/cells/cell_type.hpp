// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace flexura::mesh {

/// Cell shapes. Node order is that of Abaqus and of the VTK file format (corners first, then mid-edge nodes
/// in the order of the edges 0-1, 1-2, 2-0, 0-3, 1-3, 2-3 for tetrahedra); readers permute foreign orders.
enum class CellType : std::uint8_t {
  tri3,
  tri6,
  quad4,
  quad8,
  quad9,  // surfaces (interfaces, pictures, sections)
  tet4,
  tet10,
  hex8,
  hex20,
  hex27,
  wedge6,
  wedge15,
  pyramid5,
  pyramid13,  // solids
  line2,
  line3  // beams, curves
};

int nodes_per_cell(CellType type);
int dimension_of(CellType type);
const char* name_of(CellType type);

}  // namespace flexura::mesh
