// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <stdexcept>
#include <string>

#include "mesh/model/cells/record.hpp"

namespace flexura::mesh {

const std::vector<CellRecord>& cell_records() {
  static const std::vector<CellRecord> all = [] {
    std::vector<CellRecord> records;
    for (auto* family : {lines, triangles, quadrilaterals, tetrahedra, bricks, wedges, pyramids})
      for (CellRecord& record : family()) records.push_back(std::move(record));
    return records;
  }();
  return all;
}

const CellRecord& record_of(CellType type) {
  static const std::vector<const CellRecord*> by_type = [] {
    std::vector<const CellRecord*> table;
    for (const CellRecord& record : cell_records()) {
      const auto at = static_cast<std::size_t>(record.type);
      if (at >= table.size()) table.resize(at + 1, nullptr);
      table[at] = &record;
    }
    return table;
  }();
  const auto at = static_cast<std::size_t>(type);
  if (at >= by_type.size() || !by_type[at])
    throw std::invalid_argument("cell type " + std::to_string(at) + " does not exist");
  return *by_type[at];
}

CellRecord::Points with_middles(const CellRecord::Points& corners,
                                const std::vector<std::array<int, 2>>& edges, int n_nodes) {
  CellRecord::Points x = CellRecord::Points::Zero(n_nodes, 3);
  x.topRows(corners.rows()) = corners;
  if (n_nodes == corners.rows()) return x;
  for (std::size_t e = 0; e < edges.size(); ++e)
    x.row(corners.rows() + static_cast<Eigen::Index>(e)) =
        0.5 * (corners.row(edges[e][0]) + corners.row(edges[e][1]));
  return x;
}

std::vector<CellFace> faces_of(const std::vector<std::vector<int>>& rings,
                               const std::vector<std::array<int, 2>>& edges, int corners, bool quadratic) {
  std::vector<CellFace> faces;
  for (const std::vector<int>& ring : rings) {
    CellFace face{ring.size() == 3 ? CellType::tri3 : CellType::quad4, ring};
    if (quadratic) {
      for (std::size_t k = 0; k < ring.size(); ++k) {
        const int a = ring[k], b = ring[(k + 1) % ring.size()];
        for (std::size_t e = 0; e < edges.size(); ++e)
          if ((edges[e][0] == a && edges[e][1] == b) || (edges[e][0] == b && edges[e][1] == a))
            face.nodes.push_back(corners + static_cast<int>(e));
      }
      face.type = ring.size() == 3 ? CellType::tri6 : CellType::quad8;
    }
    faces.push_back(std::move(face));
  }
  return faces;
}

}  // namespace flexura::mesh
