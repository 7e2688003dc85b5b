// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/recovery/peak_stress.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "reduce/estimate/cell_data.hpp"
#include "reduce/estimate/sharp_edges.hpp"
#include "reduce/estimate/stress_recovery.hpp"
#include "reduce/recovery/stress.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;
using Vector6 = Eigen::Matrix<double, 6, 1>;

namespace {

double von_mises(const Eigen::Ref<const Vector6>& s) {
  const double xy = s(0) - s(1), yz = s(1) - s(2), zx = s(2) - s(0);
  return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3.0 * s.tail<3>().squaredNorm());
}

/// Calls use(block, row) for all solids.
template <class Use>
void for_each_solid(const mesh::Mesh& mesh, const Use& use) {
  for (std::size_t b = 0; b < mesh.solids.size(); ++b)
    for (Index row = 0; row < mesh.solids[b].nodes.rows(); ++row) use(b, row);
}

/// Nodes of cells that touch a marked one.
std::vector<char> with_neighbours(const mesh::Mesh& mesh, const std::vector<char>& marked) {
  std::vector<char> out = marked;
  for_each_solid(mesh, [&](std::size_t b, Index row) {
    const auto nodes = mesh.solids[b].nodes.row(row);
    if (std::any_of(nodes.begin(), nodes.end(),
                    [&](mesh::Index n) { return marked[static_cast<std::size_t>(n)] != 0; }))
      for (const mesh::Index n : nodes) out[static_cast<std::size_t>(n)] = 1;
  });
  return out;
}

/// The place of the marked node that is nearest to another.
Eigen::Vector3d nearest(const mesh::Mesh& mesh, const std::vector<char>& marked, mesh::Index node) {
  Index best = node;
  double least = HUGE_VAL;
  for (Index n = 0; n < mesh.points.rows(); ++n)
    if (marked[static_cast<std::size_t>(n)])
      if (const double d = (mesh.points.row(n) - mesh.points.row(node)).squaredNorm(); d < least)
        least = d, best = n;
  return mesh.points.row(best).transpose();
}

/// Which cells have a node.
class CellsOfNodes {
 public:
  explicit CellsOfNodes(const mesh::Mesh& mesh) : first_(static_cast<std::size_t>(mesh.n_nodes()) + 1, 0) {
    for_each_solid(mesh, [&](std::size_t b, Index row) {
      for (const mesh::Index n : mesh.solids[b].nodes.row(row)) ++first_[static_cast<std::size_t>(n) + 1];
    });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    cells_.resize(first_.back());
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    for_each_solid(mesh, [&](std::size_t b, Index row) {
      for (const mesh::Index n : mesh.solids[b].nodes.row(row))
        cells_[next[static_cast<std::size_t>(n)]++] = {b, row};
    });
  }
  using Cell = std::pair<std::size_t, Index>;  ///< block, row
  /// Within some rings of a node, ascending.
  std::set<Cell> around(const mesh::Mesh& mesh, mesh::Index node, int rings) const {
    std::set<Cell> out;
    std::set<mesh::Index> nodes = {node};
    for (int ring = 0; ring < rings; ++ring) {
      for (const mesh::Index n : nodes)
        for (std::size_t k = first_[static_cast<std::size_t>(n)]; k < first_[static_cast<std::size_t>(n) + 1];
             ++k)
          out.insert(cells_[k]);
      for (const auto& [b, row] : out)
        nodes.insert(mesh.solids[b].nodes.row(row).begin(), mesh.solids[b].nodes.row(row).end());
    }
    return out;
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<Cell> cells_;
};

/// The cells around a node, as a part of its own.
struct Surroundings {
  Part part;
  std::map<mesh::Index, mesh::Index> number;  ///< of the whole part's nodes
};

Surroundings around(const Part& part, const CellsOfNodes& cells, mesh::Index centre) {
  constexpr int kRings = 4;  // a patch takes in two rings around its cells
  Surroundings out;
  out.part.materials = part.materials;
  out.part.formulation = part.formulation;
  std::vector<std::vector<Index>> rows(part.mesh.solids.size());
  for (const auto& [b, row] : cells.around(part.mesh, centre, kRings)) rows[b].push_back(row);
  for (std::size_t b = 0; b < rows.size(); ++b) {
    if (rows[b].empty()) continue;
    const mesh::CellBlock& block = part.mesh.solids[b];
    mesh::CellBlock kept{
        .type = block.type, .variant = block.variant, .nodes = block.nodes(rows[b], Eigen::all)};
    if (!block.material.empty())
      for (const Index row : rows[b]) kept.material.push_back(block.material[static_cast<std::size_t>(row)]);
    for (mesh::Index& node : kept.nodes.reshaped())
      node = out.number.emplace(node, static_cast<mesh::Index>(out.number.size())).first->second;
    out.part.mesh.solids.push_back(std::move(kept));
  }
  out.part.mesh.points.resize(static_cast<Index>(out.number.size()), 3);
  for (const auto& [from, to] : out.number) out.part.mesh.points.row(to) = part.mesh.points.row(from);
  return out;
}

/// Errors of the nodal stress s at a node for each of the states U, as von Mises stresses of differences.
Eigen::VectorXd errors_at(const Part& part, const CellsOfNodes& cells_of, mesh::Index node, int material,
                          const MatrixXd& U, const std::vector<Index>& states, const MatrixXd& s) {
  const Surroundings near = around(part, cells_of, node);
  const auto n = static_cast<Index>(states.size());
  MatrixXd u(3 * near.part.mesh.points.rows(), n);
  for (const auto& [from, to] : near.number)
    u.middleRows<3>(3 * static_cast<Index>(to)) =
        U.middleRows<3>(3 * static_cast<Index>(from))(Eigen::all, states);
  const StressRecovery recovery(near.part);
  const Eigen::MatrixXf smooth = recovery.recover(u);
  const mesh::Index centre = near.number.at(node);
  Eigen::VectorXd square = Eigen::VectorXd::Zero(n), from_smooth = square;
  double cells = 0.0;
  for (std::size_t b = 0; b < near.part.mesh.solids.size(); ++b) {
    const mesh::CellBlock& block = near.part.mesh.solids[b];
    const TabulatedRule at_nodes = tabulate(
        block.type,
        {mesh::reference_nodes(block.type), Eigen::VectorXd::Ones(mesh::nodes_per_cell(block.type))});
    for (Index row = 0; row < block.nodes.rows(); ++row)
      for (Index a = 0; a < block.nodes.cols(); ++a) {
        if (block.nodes(row, a) != centre || static_cast<int>(material_of(block, row)) != material) continue;
        MatrixXd of_cell(3 * block.nodes.cols(), n);
        for (Index c = 0; c < block.nodes.cols(); ++c)
          of_cell.middleRows<3>(3 * c) = u.middleRows<3>(3 * static_cast<Index>(block.nodes(row, c)));
        const MatrixXd own =
            CellStress(near.part, block, row).at(at_nodes.points[static_cast<std::size_t>(a)], of_cell);
        const Index place = 6 * static_cast<Index>(recovery.places(b)(row, a));
        for (Index k = 0; k < n; ++k) {
          const double off = von_mises(own.col(k) - s.col(k));
          square(k) += off * off;
          from_smooth(k) = von_mises(smooth.block<6, 1>(place, k).cast<double>() - s.col(k));
        }
        cells += 1.0;
      }
  }
  if (cells == 0.0) return Eigen::VectorXd::Constant(n, HUGE_VAL);
  return from_smooth.cwiseMax(0.5 * (square / cells).cwiseSqrt());
}

}  // namespace

std::vector<PeakStress> peak_stresses(const Part& part, const MatrixXd& U, const MatrixXd& stress,
                                      const std::vector<mesh::Index>& nodes, const MatrixXd& Y) {
  std::vector<PeakStress> out(static_cast<std::size_t>(Y.cols()));
  if (part.mesh.solids.empty() || stress.size() == 0) return out;
  const std::vector<char> sharp = nodes_at_sharp_edges(part), unbounded = with_neighbours(part.mesh, sharp);
  const MatrixXd sigma = stress * Y;
  const std::vector<std::pair<int, int>> materials = nodal_materials(part, nodes);
  std::vector<double> size(static_cast<std::size_t>(part.mesh.n_nodes()));
  std::vector<char> greatest(size.size());
  std::map<std::size_t, std::vector<std::size_t>> states_of;  // of the places among `nodes` that are judged
  for (std::size_t k = 0; k < out.size(); ++k) {
    std::fill(size.begin(), size.end(), -1.0);
    std::fill(greatest.begin(), greatest.end(), char{1});
    for (std::size_t v = 0; v < nodes.size(); ++v)
      size[static_cast<std::size_t>(nodes[v])] =
          von_mises(sigma.block<6, 1>(6 * static_cast<Index>(v), static_cast<Index>(k)));
    for_each_solid(part.mesh, [&](std::size_t b, Index row) {
      double most = -1.0;
      for (const mesh::Index n : part.mesh.solids[b].nodes.row(row))
        most = std::max(most, size[static_cast<std::size_t>(n)]);
      for (const mesh::Index n : part.mesh.solids[b].nodes.row(row))
        if (size[static_cast<std::size_t>(n)] < most) greatest[static_cast<std::size_t>(n)] = 0;
    });
    std::size_t at = nodes.size(), top = 0;
    for (std::size_t v = 0; v < nodes.size(); ++v) {
      const auto n = static_cast<std::size_t>(nodes[v]);
      if (size[n] > size[static_cast<std::size_t>(nodes[top])]) top = v;
      if (greatest[n] && !unbounded[n] &&
          (at == nodes.size() || size[n] > size[static_cast<std::size_t>(nodes[at])]))
        at = v;
    }
    out[k].singular = unbounded[static_cast<std::size_t>(nodes[top])] != 0;
    if (out[k].singular) out[k].singular_at = nearest(part.mesh, sharp, nodes[top]);
    if (at == nodes.size() || !(size[static_cast<std::size_t>(nodes[at])] > 0.0)) continue;
    out[k].node = nodes[at];
    out[k].at = part.mesh.points.row(nodes[at]).transpose();
    out[k].von_mises = size[static_cast<std::size_t>(nodes[at])];
    states_of[at].push_back(k);
  }
  const CellsOfNodes cells_of(part.mesh);
  for (const auto& [at, states] : states_of) {
    const std::vector<Index> columns(states.begin(), states.end());
    const Eigen::VectorXd errors = errors_at(part, cells_of, nodes[at], materials[at].first, U, columns,
                                             sigma(Eigen::seqN(6 * static_cast<Index>(at), 6), columns));
    for (std::size_t k = 0; k < states.size(); ++k)
      if (const double error = errors(static_cast<Index>(k)) / out[states[k]].von_mises; std::isfinite(error))
        out[states[k]].error = error;
  }
  return out;
}

}  // namespace flexura::reduce
