// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/mesh_sizes.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// Calls use(cell, corner nodes' block, row) for the solids in their order.
template <class Use>
void for_each_solid(const mesh::Mesh& mesh, const Use& use) {
  Index cell = 0;
  for (const mesh::CellBlock& block : mesh.solids)
    for (Index row = 0; row < block.nodes.rows(); ++row, ++cell) use(cell, block, row);
}

bool touches(const mesh::CellBlock& block, Index row, const std::vector<char>& sharp) {
  for (int a = 0; a < mesh::shape_of(block.type).corners; ++a)
    if (sharp[static_cast<std::size_t>(block.nodes(row, a))]) return true;
  return false;
}

/// The mean length of the edges of the surface at each node; 0 inside.
std::vector<double> surface_edges(const mesh::Mesh& mesh) {
  std::vector<double> sum(static_cast<std::size_t>(mesh.n_nodes()), 0.0), count(sum);
  for (const mesh::CellBlock& block : mesh.boundary) {
    const int corners = mesh::shape_of(block.type).corners;
    for (Index row = 0; row < block.nodes.rows(); ++row)
      for (int c = 0; c < corners; ++c) {
        const mesh::Index a = block.nodes(row, c), b = block.nodes(row, (c + 1) % corners);
        const double length = (mesh.points.row(a) - mesh.points.row(b)).norm();
        for (const mesh::Index node : {a, b}) {
          sum[static_cast<std::size_t>(node)] += length;
          count[static_cast<std::size_t>(node)] += 1.0;
        }
      }
  }
  for (std::size_t k = 0; k < sum.size(); ++k)
    if (count[k] > 0.0) sum[k] /= count[k];
  return sum;
}

struct Exponents {
  double a, d;  ///< of the error and of the cells, by the size
};

// Of an edge of 270 degrees 2 lambda = 1.09, around what is clamped 1 to 1.4.  In the interior a little less than 2p, as
// sizes vary.
std::vector<Exponents> exponents_of(const mesh::Mesh& mesh, const std::vector<char>& sharp) {
  std::vector<Exponents> out;
  for_each_solid(mesh, [&](Index, const mesh::CellBlock& block, Index row) {
    const bool linear = block.nodes.cols() == mesh::shape_of(block.type).corners;
    out.push_back(touches(block, row, sharp) ? Exponents{1.1, 1.0} : Exponents{linear ? 2.0 : 3.0, 3.0});
  });
  return out;
}

}  // namespace

VectorXd cell_factors(const mesh::Mesh& mesh, const MatrixXd& share, const std::vector<char>& sharp,
                      double aim, double coarsest) {
  constexpr double kFinest = 1.0 / 16.0;  // finer is a guess
  constexpr int kSweeps = 30;
  // An error goes with its multiplier like mu^(-a / (a + d)), about the root: this much of the way to it, as sums share cells.
  constexpr double kStep = 1.5;
  const std::vector<Exponents> by = exponents_of(mesh, sharp);
  VectorXd factor = VectorXd::Ones(share.rows());
  if (share.size() == 0 || !(share.maxCoeff() > 0.0)) return factor;
  VectorXd multiplier = VectorXd::Ones(share.cols()), left(share.cols());
  const auto divide = [&](double level) {  // makes `left` the sums where a e f^(a+d) / d is that level
    const VectorXd error = share * multiplier;
    const double least = 1e-6 * error.maxCoeff();
    left.setZero();
    for (Index k = 0; k < share.rows(); ++k) {
      const auto [a, d] = by[static_cast<std::size_t>(k)];
      const double e = std::max(error(k), least);
      factor(k) = std::clamp(std::pow(level * d / (a * e), 1.0 / (a + d)), kFinest, coarsest);
      left += std::pow(factor(k), a) * share.row(k).transpose();
    }
    return left.maxCoeff();
  };
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    divide(1.0);
    for (Index k = 0; k < share.cols(); ++k)
      multiplier(k) *= std::pow(std::clamp(left(k) / aim, 1e-2, 1e2), kStep);
    multiplier = multiplier.cwiseMax(1e-12 * multiplier.maxCoeff());
  }
  double low = std::log(1e-6), high = std::log(1e6);
  for (int k = 0; k < 50; ++k) {
    const double middle = 0.5 * (low + high);
    (divide(std::exp(middle)) > aim ? high : low) = middle;
  }
  divide(std::exp(low));
  return factor;
}

double cells_for(const mesh::Mesh& mesh, const VectorXd& factor, const std::vector<char>& sharp) {
  const std::vector<Exponents> by = exponents_of(mesh, sharp);
  double sum = 0.0;
  for (Index k = 0; k < factor.size(); ++k) {
    const double f = factor(k);
    // Between the edge and the cell's old size: layers, the cells of each twice as large along the edge, too, as those of the
    // last.  1 + 1/2 + 1/4 + ... + f
    const double layers = by[static_cast<std::size_t>(k)].d == 1.0 && f < 1.0 ? 2.0 - f : 1.0;
    sum += layers * std::pow(f, -by[static_cast<std::size_t>(k)].d);
  }
  return sum / static_cast<double>(std::max<Index>(factor.size(), 1));
}

std::vector<double> size_points(const mesh::Mesh& mesh, const VectorXd& factor,
                                const std::vector<char>& sharp) {
  const auto n = static_cast<std::size_t>(mesh.n_nodes());
  const auto length = [&](mesh::Index a, mesh::Index b) {
    return (mesh.points.row(a) - mesh.points.row(b)).norm();
  };
  std::vector<double> size(n, 0.0), count(n, 0.0);
  // A mesher's size is that of the edges on the surface.  Those of the cells are longer where walls are a single cell thick
  // (diagonals): taken for sizes they would make the next mesh coarser by a quarter.
  const std::vector<double> on_surface = surface_edges(mesh);
  for_each_solid(mesh, [&](Index cell, const mesh::CellBlock& block, Index row) {
    const mesh::CellShape& shape = mesh::shape_of(block.type);
    double mean = 0.0;
    for (const auto& edge : shape.edges)
      mean += length(block.nodes(row, edge[0]), block.nodes(row, edge[1])) /
              static_cast<double>(shape.edges.size());
    const bool at_edge = touches(block, row, sharp);
    for (int a = 0; a < shape.corners; ++a) {
      const auto node = static_cast<std::size_t>(block.nodes(row, a));
      // What a cell at the edge wants it wants there.
      const double f = at_edge && !sharp[node] ? std::max(factor(cell), 1.0) : factor(cell);
      size[node] += std::log(f * (on_surface[node] > 0.0 ? std::min(on_surface[node], mean) : mean));
      count[node] += 1.0;
    }
  });
  for (std::size_t node = 0; node < n; ++node)
    if (count[node] > 0.0) size[node] = std::exp(size[node] / count[node]);
  constexpr double kGrowth = 0.5;
  for (int sweep = 0; sweep < 3; ++sweep)
    for_each_solid(mesh, [&](Index, const mesh::CellBlock& block, Index row) {
      for (const auto& edge : mesh::shape_of(block.type).edges) {
        const mesh::Index a = block.nodes(row, edge[0]), b = block.nodes(row, edge[1]);
        double &at_a = size[static_cast<std::size_t>(a)], &at_b = size[static_cast<std::size_t>(b)];
        at_a = std::min(at_a, at_b + kGrowth * length(a, b));
        at_b = std::min(at_b, at_a + kGrowth * length(a, b));
      }
    });
  std::vector<double> out;
  const auto put = [&out](const Vector3d& x, double h) { out.insert(out.end(), {x.x(), x.y(), x.z(), h}); };
  for (mesh::Index node = 0; node < mesh.n_nodes(); ++node)
    if (count[static_cast<std::size_t>(node)] > 0.0)
      put(mesh.points.row(node).transpose(), size[static_cast<std::size_t>(node)]);
  // The mesher takes the size of the nearest point: between the ends of an edge that differ, more of them.
  std::map<std::array<mesh::Index, 2>, char> done;
  for_each_solid(mesh, [&](Index, const mesh::CellBlock& block, Index row) {
    const mesh::CellShape& shape = mesh::shape_of(block.type);
    Vector3d centre = Vector3d::Zero();
    double at_centre = 0.0, smallest = HUGE_VAL;
    for (int c = 0; c < shape.corners; ++c) {
      const mesh::Index node = block.nodes(row, c);
      centre += mesh.points.row(node).transpose() / shape.corners;
      at_centre += size[static_cast<std::size_t>(node)] / shape.corners;
      smallest = std::min(smallest, size[static_cast<std::size_t>(node)]);
    }
    if (at_centre > 1.2 * smallest) put(centre, at_centre);
    for (const auto& edge : shape.edges) {
      std::array<mesh::Index, 2> ends{block.nodes(row, edge[0]), block.nodes(row, edge[1])};
      std::sort(ends.begin(), ends.end());
      const double a = size[static_cast<std::size_t>(ends[0])], b = size[static_cast<std::size_t>(ends[1])];
      if (std::max(a, b) < 1.2 * std::min(a, b) || !done.emplace(ends, 1).second) continue;
      const Vector3d from = mesh.points.row(ends[0]), to = mesh.points.row(ends[1]);
      const int pieces =
          std::clamp(static_cast<int>(std::lround(length(ends[0], ends[1]) / std::min(a, b))), 2, 8);
      for (int k = 1; k < pieces; ++k) {
        const double t = static_cast<double>(k) / pieces;
        put((1.0 - t) * from + t * to, (1.0 - t) * a + t * b);
      }
    }
  });
  return out;
}

}  // namespace flexura::reduce
