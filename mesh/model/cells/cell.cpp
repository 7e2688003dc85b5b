// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/cells/cell.hpp"

#include <algorithm>

#include "mesh/model/cells/record.hpp"

namespace flexura::mesh {

int nodes_per_cell(CellType type) {
  return static_cast<int>(record_of(type).nodes.rows());
}
int dimension_of(CellType type) {
  return record_of(type).dimension;
}
const char* name_of(CellType type) {
  return record_of(type).name;
}

const CellShape& shape_of(CellType type) {
  return record_of(type).shape;
}

const Eigen::Matrix<double, Eigen::Dynamic, 3>& reference_nodes(CellType type) {
  return record_of(type).nodes;
}

const Quadrature& volume_quadrature(CellType type) {
  return record_of(type).volume;
}

const Quadrature& stiffness_quadrature(CellType type) {
  return record_of(type).stiffness;
}

ShapeValues evaluate_shape(CellType type, const Eigen::Vector3d& point) {
  const CellRecord& record = record_of(type);
  Eigen::Vector3d p = point;
  if (record.shape.corners == 5) p.z() = std::min(p.z(), 1 - 1e-9);  // pyramids: not at the apex itself
  const std::vector<Dual> N = record.functions(
      record, {Dual::variable(p.x(), 0), Dual::variable(p.y(), 1), Dual::variable(p.z(), 2)});
  const auto n = static_cast<Eigen::Index>(N.size());
  ShapeValues values{Eigen::VectorXd(n), Eigen::Matrix<double, Eigen::Dynamic, 3>(n, 3)};
  for (Eigen::Index k = 0; k < n; ++k) {
    values.N[k] = N[static_cast<std::size_t>(k)].value;
    values.dN.row(k) = N[static_cast<std::size_t>(k)].gradient.transpose();
  }
  return values;
}

}  // namespace flexura::mesh
