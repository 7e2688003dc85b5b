// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/projection.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mesh/model/cells/cell.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Vector3d;

// Into the reference cell: of triangles x, y >= 0, x + y <= 1, of quadrilaterals |x|, |y| <= 1.
Vector3d inside(CellType type, Vector3d r) {
  if (shape_of(type).corners == 4) return {std::clamp(r.x(), -1.0, 1.0), std::clamp(r.y(), -1.0, 1.0), 0.0};
  r.x() = std::max(r.x(), 0.0), r.y() = std::max(r.y(), 0.0);
  if (const double over = r.x() + r.y() - 1.0; over > 0) {
    r.x() = std::clamp(r.x() - 0.5 * over, 0.0, 1.0);
    r.y() = 1.0 - r.x();
  }
  return {r.x(), r.y(), 0.0};
}

}  // namespace

std::optional<Projection> project(const Vector3d& point, const std::vector<SurfaceFace>& faces,
                                  const std::function<const Vector3d&(Index)>& place_of, double reach) {
  std::optional<Projection> best;
  Eigen::Matrix<double, Eigen::Dynamic, 3> x;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const SurfaceFace& face = faces[f];
    Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
    for (const Index node : face.nodes) {
      low = low.cwiseMin(place_of(node));
      high = high.cwiseMax(place_of(node));
    }
    const double bulge =
        face.nodes.size() > 4 ? 0.25 * (high - low).norm() : 0.0;  // a curved face leaves its nodes' box
    if (((low - point).array() > reach + bulge).any() || ((point - high).array() > reach + bulge).any())
      continue;
    x.resize(static_cast<Eigen::Index>(face.nodes.size()), 3);
    for (std::size_t k = 0; k < face.nodes.size(); ++k)
      x.row(static_cast<Eigen::Index>(k)) = place_of(face.nodes[k]).transpose();
    // Gauss and Newton's iteration for the foot of the perpendicular, kept in the cell.
    Vector3d r = reference_nodes(face.type).topRows(shape_of(face.type).corners).colwise().mean().transpose();
    Projection here;
    here.face = f;
    for (int iteration = 0; iteration < 50; ++iteration) {
      const ShapeValues shape = evaluate_shape(face.type, r);
      here.N = shape.N;
      here.place = x.transpose() * shape.N;
      const Eigen::Matrix<double, 3, 2> J = x.transpose() * shape.dN.leftCols<2>();
      const Eigen::Vector2d step = (J.transpose() * J).inverse() * (J.transpose() * (point - here.place));
      if (!step.allFinite()) break;
      const Vector3d next = inside(face.type, r + Vector3d(step.x(), step.y(), 0.0));
      if ((next - r).norm() < 1e-14) break;
      r = next;
    }
    here.distance = (here.place - point).norm();
    if (here.distance <= reach && (!best || here.distance < best->distance)) best = here;
  }
  return best;
}

}  // namespace flexura::mesh
