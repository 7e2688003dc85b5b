// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/mesh.hpp"

/// Shape functions at fixed points, and the Jacobians of cells there: for what is measured on meshes.
namespace flexura::mesh {

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;
using CellPoints = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 27, 3>;

/// Shape functions at fixed points of the reference cell, evaluated once for a block.
struct Samples {
  std::vector<ShapeValues> at;
  Eigen::VectorXd weights;  // empty for plain points
  Samples(CellType type, const Points& points) {
    for (Eigen::Index k = 0; k < points.rows(); ++k)
      at.push_back(evaluate_shape(type, points.row(k).transpose()));
  }
  Samples(CellType type, const Quadrature& rule) : Samples(type, rule.points) { weights = rule.weights; }
};

inline CellPoints points_of(const Mesh& mesh, const CellBlock& block, Index cell) {
  CellPoints x(block.nodes.cols(), 3);
  for (Eigen::Index k = 0; k < block.nodes.cols(); ++k) x.row(k) = mesh.points.row(block.nodes(cell, k));
  return x;
}

inline Eigen::Matrix3d jacobian(const CellPoints& x, const ShapeValues& shape) {
  return x.transpose() * shape.dN;  // column j = dx/dr_j
}

inline double determinant(const Eigen::Matrix3d& J) {
  return J.col(0).dot(J.col(1).cross(J.col(2)));
}

}  // namespace flexura::mesh
