// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/recovery/node_motions.hpp"

#include "reduce/elements/solid.hpp"
#include "reduce/estimate/cell_data.hpp"

namespace flexura::reduce {

using Eigen::Index;

namespace {

// Adds what the cells of a block say of rot u / 2 to rows 3 to 5 of the places of their nodes, and counts them.
void add_curls(const Part& part, const mesh::CellBlock& block, const Eigen::MatrixXd& T,
               const std::vector<Index>& place, Eigen::MatrixXd& out, std::vector<int>& count) {
  const TabulatedRule at_nodes =
      tabulate(block.type, {mesh::reference_nodes(block.type), Eigen::VectorXd::Ones(block.nodes.cols())});
  for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
    const NodePositions x = positions(part.mesh, block, cell);
    const double size = (x.colwise().maxCoeff() - x.colwise().minCoeff()).norm();
    for (Index c = 0; c < x.rows(); ++c) {
      const Index k = place[block.nodes(cell, c)];
      if (k < 0) continue;
      NodePositions gradient;
      const double det = spatial_gradients(at_nodes.points[static_cast<std::size_t>(c)], x, gradient);
      // Collapsed cells: next to nothing of the cell's size, or no number at the tip of a pyramid.
      if (!(det > 1e-9 * size * size * size) || !gradient.allFinite()) continue;
      ++count[static_cast<std::size_t>(k)];
      for (Index a = 0; a < x.rows(); ++a) {
        const Index row = 3 * static_cast<Index>(block.nodes(cell, a));
        for (Index d = 0; d < 3; ++d) {
          const Index e = (d + 1) % 3, f = (d + 2) % 3;
          out.row(6 * k + 3 + d) += 0.5 * (gradient(a, e) * T.row(row + f) - gradient(a, f) * T.row(row + e));
        }
      }
    }
  }
}

}  // namespace

std::vector<mesh::Index> nodes_of_mesh(const Part& part) {
  const auto& label = part.mesh.node_label;
  std::vector<char> is_own(static_cast<std::size_t>(part.mesh.n_nodes()), 1);
  for (const Follower& follower : part.followers) is_own[static_cast<std::size_t>(follower.point)] = 0;
  std::vector<mesh::Index> nodes;
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) {
    const auto k = static_cast<std::size_t>(node);
    if (is_own[k] && (label.empty() || label[k] >= 0)) nodes.push_back(node);
  }
  return nodes;
}

NodeMotions node_motions(const Part& part, const Eigen::MatrixXd& T, const Eigen::MatrixXd& rotations,
                         const std::vector<int>& rotation_of) {
  NodeMotions out{.nodes = nodes_of_mesh(part)};
  const std::size_t n_k = out.nodes.size();
  out.rotations.resize(n_k, NodeMotions::Rotation::unknown);
  out.T.setZero(6 * static_cast<Index>(n_k), T.cols());
  std::vector<Index> place(static_cast<std::size_t>(part.mesh.n_nodes()), -1);
  for (std::size_t k = 0; k < n_k; ++k) {
    const auto node = static_cast<std::size_t>(out.nodes[k]);
    const auto row = 6 * static_cast<Index>(k);
    out.T.middleRows<3>(row) = T.middleRows<3>(3 * static_cast<Index>(node));
    if (const int turns = rotation_of.empty() ? -1 : rotation_of[node]; turns >= 0) {
      out.rotations[k] = NodeMotions::Rotation::own;
      out.T.middleRows<3>(row + 3) = rotations.middleRows<3>(3 * static_cast<Index>(turns));
    } else {
      place[node] = static_cast<Index>(k);
    }
  }
  std::vector<int> count(n_k, 0);
  for (const mesh::CellBlock& block : part.mesh.solids) add_curls(part, block, T, place, out.T, count);
  for (std::size_t k = 0; k < n_k; ++k) {
    if (count[k] == 0) continue;
    out.rotations[k] = NodeMotions::Rotation::curl;
    out.T.middleRows<3>(6 * static_cast<Index>(k) + 3) /= count[k];
  }
  return out;
}

}  // namespace flexura::reduce
