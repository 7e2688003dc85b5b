// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/estimate/enriched_mesh.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>

#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/estimate/cell_data.hpp"
#include "reduce/estimate/enrichment.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// An edge by its two corners, a face by its three lowest: no two faces of a mesh share three.
using Key = std::array<mesh::Index, 3>;
constexpr mesh::Index kNone = -1;  // on an edge, in place of a third corner

Key key_of(const EnrichmentFunction& f, const mesh::CellBlock& block, Index row) {
  std::array<mesh::Index, 4> nodes{};
  int n = 0;
  for (const int corner : f.corners)
    if (corner >= 0) nodes[static_cast<std::size_t>(n++)] = block.nodes(row, corner);
  std::sort(nodes.begin(), nodes.begin() + n);
  return n == 2 ? Key{nodes[0], nodes[1], kNone} : Key{nodes[0], nodes[1], nodes[2]};
}

float sign_of(const EnrichmentFunction& f, const mesh::CellBlock& block, Index row) {
  return f.odd && block.nodes(row, f.corners[0]) > block.nodes(row, f.corners[1]) ? -1.0f : 1.0f;
}

}  // namespace

EnrichedMesh::EnrichedMesh(const Part& part) : part_(part) {
  std::vector<Key> keys;
  for (std::size_t b = 0; b < part.mesh.solids.size(); ++b) {
    const mesh::CellBlock& block = part.mesh.solids[b];
    const std::vector<EnrichmentFunction>& functions = enrichment_of(block.type);
    for (Index row = 0; row < block.nodes.rows(); ++row) {
      cells_.push_back({static_cast<int>(b), row, keys.size(), static_cast<int>(functions.size())});
      for (const EnrichmentFunction& f : functions) {
        keys.push_back(key_of(f, block, row));
        sign_.push_back(sign_of(f, block, row));
      }
    }
  }
  // Keys by their lowest node, the few of a node by the others.
  std::vector<std::size_t> first_of(static_cast<std::size_t>(part.mesh.n_nodes()) + 1, 0), order(keys.size());
  const auto node_of = [&](std::size_t k) { return static_cast<std::size_t>(keys[k][0]); };
  for (std::size_t k = 0; k < keys.size(); ++k) ++first_of[node_of(k) + 1];
  for (std::size_t node = 1; node < first_of.size(); ++node) first_of[node] += first_of[node - 1];
  std::vector<std::size_t> next = first_of;
  for (std::size_t k = 0; k < keys.size(); ++k) order[next[node_of(k)]++] = k;
  // The first of those that share a key, in the order of the cells.
  std::vector<std::size_t> first_alike(keys.size());
  for (std::size_t node = 0; node + 1 < first_of.size(); ++node) {
    const auto begin = order.begin() + static_cast<std::ptrdiff_t>(first_of[node]),
               end = order.begin() + static_cast<std::ptrdiff_t>(first_of[node + 1]);
    std::sort(begin, end, [&](std::size_t a, std::size_t b) {
      return keys[a] < keys[b] || (keys[a] == keys[b] && a < b);
    });
    for (auto k = begin; k != end; ++k)
      first_alike[*k] = k != begin && keys[*k] == keys[*(k - 1)] ? first_alike[*(k - 1)] : *k;
  }
  numbers_.resize(keys.size());
  for (std::size_t k = 0; k < keys.size(); ++k)
    numbers_[k] = first_alike[k] == k ? n_functions_++ : numbers_[first_alike[k]];
  leave_out_rigid_faces();
}

// Functions all of whose corners follow a rigid interface.
void EnrichedMesh::leave_out_rigid_faces() {
  held_.assign(static_cast<std::size_t>(part_.mesh.n_nodes()), 0);
  std::vector<int> tie_of(static_cast<std::size_t>(part_.mesh.n_nodes()), -1);
  bool any = false;
  for (std::size_t k = 0; k < part_.interfaces.size(); ++k) {
    if (part_.interfaces[k].tie != Tie::rigid) continue;
    any = true;
    for (const mesh::Index node : part_.interfaces[k].set.nodes) {
      tie_of[static_cast<std::size_t>(node)] = static_cast<int>(k);
      held_[static_cast<std::size_t>(node)] = 1;
    }
  }
  if (!any) return;
  std::vector<char> out(static_cast<std::size_t>(n_functions_), 0);
  for (const Cell& cell : cells_) {
    const mesh::CellBlock& block = part_.mesh.solids[static_cast<std::size_t>(cell.block)];
    const mesh::CellShape& shape = mesh::shape_of(block.type);
    const auto tie = [&](Index a) { return tie_of[static_cast<std::size_t>(block.nodes(cell.row, a))]; };
    const std::vector<EnrichmentFunction>& functions = enrichment_of(block.type);
    for (std::size_t f = 0; f < functions.size(); ++f) {
      const int first = tie(functions[f].corners[0]);
      bool follows = first >= 0;
      for (const int corner : functions[f].corners) follows = follows && (corner < 0 || tie(corner) == first);
      // The middle of an edge between two tied corners may lie off the face.
      if (follows && f < shape.edges.size() && block.nodes.cols() > shape.corners)
        follows = tie(shape.corners + static_cast<Index>(f)) == first;
      if (follows) out[static_cast<std::size_t>(numbers_[cell.first_function + f])] = 1;
    }
  }
  for (int& number : numbers_)
    if (out[static_cast<std::size_t>(number)]) number = -1;
}

// The linear traction of an averaging tie (average.hpp) does work on the functions of its faces.
std::vector<EnrichedMesh::Load> EnrichedMesh::tractions(const MatrixXd& force_b) const {
  std::vector<Load> out;
  std::map<Key, int> numbers;  // of the functions on averaged faces
  std::vector<char> averaged(static_cast<std::size_t>(part_.mesh.n_nodes()), 0);
  const auto by_faces = [](const InterfaceSpec& interface) {
    return interface.tie == Tie::average && interface.weights.empty() && !interface.set.faces.empty();
  };
  for (const InterfaceSpec& interface : part_.interfaces)
    if (by_faces(interface))
      for (const mesh::Index node : interface.set.nodes) averaged[static_cast<std::size_t>(node)] = 1;
  for (const Cell& cell : cells_) {
    const mesh::CellBlock& block = part_.mesh.solids[static_cast<std::size_t>(cell.block)];
    const std::vector<EnrichmentFunction>& functions = enrichment_of(block.type);
    for (std::size_t f = 0; f < functions.size(); ++f) {
      bool all = true;
      for (const int corner : functions[f].corners)
        all = all && (corner < 0 || averaged[static_cast<std::size_t>(block.nodes(cell.row, corner))]);
      if (all) numbers[key_of(functions[f], block, cell.row)] = numbers_[cell.first_function + f];
    }
  }
  Index first_dof = 0;
  for (const InterfaceSpec& interface : part_.interfaces) {
    const auto n_dofs = static_cast<Index>(interface.directions.size());
    const Index first = first_dof;
    first_dof += n_dofs;
    if (n_dofs == 0 || !by_faces(interface)) continue;
    // Radius and scaled rotations as in average.cpp.
    double radius = 0.0;
    for (const mesh::Index node : interface.set.nodes)
      radius = std::max(radius, (part_.mesh.points.row(node).transpose() - interface.point).norm());
    Vector6 scale;
    scale << 1, 1, 1, 1 / radius, 1 / radius, 1 / radius;
    Eigen::Matrix<double, 6, 6> gram = Eigen::Matrix<double, 6, 6>::Zero();
    std::map<int, Eigen::Matrix<double, 3, 6>> work;  // of each function: integral w D dA
    for (const mesh::CellBlock& block : interface.set.faces) {
      const std::vector<EnrichmentFunction>& functions = enrichment_of(block.type);
      const TabulatedRule rule = tabulate(block.type, mesh::volume_quadrature(block.type));
      std::vector<EnrichmentValues> gained;
      for (const TabulatedRule::Point& point : rule.points)
        gained.push_back(evaluate_enrichment(block.type, point.xi));
      for (Index row = 0; row < block.nodes.rows(); ++row) {
        const NodePositions x = positions(part_.mesh, block, row);
        for (std::size_t q = 0; q < rule.points.size(); ++q) {
          const Eigen::Matrix3d tangents = rule.points[q].dN.transpose() * x;
          const double area =
              rule.points[q].weight * tangents.row(0).transpose().cross(tangents.row(1).transpose()).norm();
          const Eigen::Vector3d off = x.transpose() * rule.points[q].N - interface.point;
          const Eigen::Matrix<double, 3, 6> D = motion_at(off) * scale.asDiagonal();
          gram += area * D.transpose() * D;
          for (std::size_t f = 0; f < functions.size(); ++f) {
            const auto number = numbers.find(key_of(functions[f], block, row));
            if (number == numbers.end() || number->second < 0) continue;
            const double w = sign_of(functions[f], block, row) * gained[q].w(static_cast<Index>(f));
            auto [at, fresh] = work.try_emplace(number->second, Eigen::Matrix<double, 3, 6>::Zero());
            at->second += (w * area) * D;
          }
        }
      }
    }
    const Eigen::Matrix<double, 6, 6> to_force = gram.ldlt().solve(Eigen::Matrix<double, 6, 6>::Identity()) *
                                                 Eigen::Matrix<double, 6, 6>(scale.asDiagonal());
    MatrixXd force = MatrixXd::Zero(6, force_b.cols());
    for (Index k = 0; k < n_dofs; ++k)
      force.row(interface.directions[static_cast<std::size_t>(k)]) = force_b.row(first + k);
    for (const auto& [function, W] : work) out.push_back({function, W * (to_force * force)});
  }
  return out;
}

}  // namespace flexura::reduce
