// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/model/geometry.hpp"
#include "mesh/model/samples.hpp"

/// How good the shapes of cells are, and curved edges made straight where they are poor.
namespace flexura::mesh {
namespace {

/// det J is evaluated here to judge a cell: nodes (without the singular apex), stiffness and volume points.
Points judging_points(CellType type) {
  const Points& nodes = reference_nodes(type);
  const Points &k = stiffness_quadrature(type).points, &v = volume_quadrature(type).points;
  Points all(nodes.rows() + k.rows() + v.rows(), 3);
  all << k, v, nodes;
  if (shape_of(type).corners == 5) all.row(k.rows() + v.rows() + 4) = k.row(0);
  return all;
}

double scaled_jacobian(CellType type, const CellPoints& x) {
  const CellShape& shape = shape_of(type);
  const double regular = shape.corners == 4 ? std::sqrt(2.) : shape.corners == 6 ? 2 / std::sqrt(3.) : 1;
  double least = std::numeric_limits<double>::max();
  for (int c = 0; c < shape.corners; ++c) {
    if (shape.corners == 5 && c == 4) continue;  // four edges meet at a pyramid's apex
    Eigen::Matrix3d E;  // the three edges of this corner, as the reference cell orders them
    Eigen::Matrix3d E_reference;
    int n = 0;
    const Points& reference = reference_nodes(type);
    for (const auto& edge : shape.edges) {
      const int other = edge[0] == c ? edge[1] : edge[1] == c ? edge[0] : -1;
      if (other < 0 || n == 3) continue;
      E.col(n) = (x.row(other) - x.row(c)).transpose();
      E_reference.col(n++) = (reference.row(other) - reference.row(c)).transpose();
    }
    const double lengths = E.col(0).norm() * E.col(1).norm() * E.col(2).norm();
    const double sign = determinant(E_reference) < 0 ? -1 : 1;
    const double value = lengths > 0 ? sign * determinant(E) / lengths : 0;
    least = std::min(least, regular * value);
  }
  return least;
}

struct Judgement {
  double least = 0, greatest = 0, least_quadrature = 0;
  double ratio() const { return greatest > 0 ? least / greatest : -1; }
};

Judgement judge(const CellPoints& x, const Samples& samples, Eigen::Index n_quadrature) {
  Judgement j{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest(),
              std::numeric_limits<double>::max()};
  for (std::size_t k = 0; k < samples.at.size(); ++k) {
    const double d = determinant(jacobian(x, samples.at[k]));
    j.least = std::min(j.least, d);
    j.greatest = std::max(j.greatest, d);
    if (static_cast<Eigen::Index>(k) < n_quadrature) j.least_quadrature = std::min(j.least_quadrature, d);
  }
  return j;
}

}  // namespace

Quality measure_quality(const Mesh& mesh) {
  Quality q;
  double sum_scaled = 0, sum_ratio = 0;
  for (const CellBlock& block : mesh.solids) {
    const Samples samples(block.type, judging_points(block.type));
    const Eigen::Index n_quadrature =
        stiffness_quadrature(block.type).points.rows() + volume_quadrature(block.type).points.rows();
    for (Index cell = 0; cell < block.nodes.rows(); ++cell, ++q.n_cells) {
      const CellPoints x = points_of(mesh, block, cell);
      const Judgement j = judge(x, samples, n_quadrature);
      const double scaled = scaled_jacobian(block.type, x), ratio = j.ratio();
      sum_scaled += scaled;
      sum_ratio += ratio;
      if (j.least_quadrature <= 0) ++q.n_inverted;
      if (ratio < kPoorRatio) ++q.n_below;
      if (q.n_cells == 0 || scaled < q.min_scaled_jacobian) {
        q.min_scaled_jacobian = scaled;
        q.worst_cell = q.n_cells;
      }
      if (q.n_cells == 0 || ratio < q.min_ratio) q.min_ratio = ratio;
    }
  }
  if (q.n_cells > 0) {
    q.mean_scaled_jacobian = sum_scaled / q.n_cells;
    q.mean_ratio = sum_ratio / q.n_cells;
  }
  return q;
}

Index straighten_poor_cells(Mesh& mesh, double poor_ratio) {
  std::vector<char> moved(static_cast<std::size_t>(mesh.n_nodes()), 0);
  // Every pass moves at least one node that had not moved, so this ends.
  for (bool again = true; again;) {
    again = false;
    for (const CellBlock& block : mesh.solids) {
      const CellShape& shape = shape_of(block.type);
      if (block.nodes.cols() <= shape.corners) continue;
      const Samples samples(block.type, judging_points(block.type));
      for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
        if (judge(points_of(mesh, block, cell), samples, 0).ratio() >= poor_ratio) continue;
        for (std::size_t e = 0; e < shape.edges.size(); ++e) {
          const Index middle = block.nodes(cell, shape.corners + static_cast<int>(e));
          if (moved[static_cast<std::size_t>(middle)]) continue;
          moved[static_cast<std::size_t>(middle)] = 1;
          mesh.points.row(middle) = 0.5 * (mesh.points.row(block.nodes(cell, shape.edges[e][0])) +
                                           mesh.points.row(block.nodes(cell, shape.edges[e][1])));
          again = true;
        }
      }
    }
  }
  return static_cast<Index>(std::count(moved.begin(), moved.end(), 1));
}

}  // namespace flexura::mesh
