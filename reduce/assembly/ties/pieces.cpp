// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/ties/pieces.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <map>
#include <stdexcept>

#include "mesh/model/disjoint_sets.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/ties/tied_numbering.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Motions = Eigen::Matrix<double, Eigen::Dynamic, 6>;

// What the interfaces of a piece hold.
Motions held_by_interfaces(const Part& part, const Pieces& pieces, int piece) {
  std::vector<Vector6> rows;
  for (const InterfaceSpec& spec : part.interfaces) {
    if (spec.tie == Tie::average || spec.tie == Tie::elastic || spec.set.nodes.empty() ||
        pieces.of_node[static_cast<std::size_t>(spec.set.nodes.front())] != piece)
      continue;
    const Eigen::Vector3d point =
        spec.tie == Tie::node ? Eigen::Vector3d(part.mesh.points.row(spec.set.nodes.front())) : spec.point;
    for (const int direction : spec.directions)
      rows.emplace_back(node_motion_at(point).row(direction).transpose());
  }
  Motions H(static_cast<Index>(rows.size()), 6);
  for (std::size_t k = 0; k < rows.size(); ++k) H.row(static_cast<Index>(k)) = rows[k].transpose();
  return H;
}

struct Extent {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double length = 1.0;
};

Extent extent_of(const Part& part, const std::vector<mesh::Index>& nodes) {
  Eigen::AlignedBox3d box;
  for (const mesh::Index node : nodes) box.extend(Eigen::Vector3d(part.mesh.points.row(node)));
  const double length = 0.5 * box.diagonal().norm();
  return {box.center(), length > 0.0 ? length : 1.0};
}

std::vector<std::vector<mesh::Index>> nodes_of(const Pieces& pieces) {
  std::vector<std::vector<mesh::Index>> nodes(pieces.sizes.size());
  for (std::size_t node = 0; node < pieces.of_node.size(); ++node)
    if (pieces.of_node[node] >= 0)
      nodes[static_cast<std::size_t>(pieces.of_node[node])].push_back(static_cast<mesh::Index>(node));
  return nodes;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> left_free(const Motions& H, const Extent& extent) {
  return H.rows() == 0 ? Eigen::Matrix<double, 6, Eigen::Dynamic>(Eigen::Matrix<double, 6, 6>::Identity())
                       : free_motions(H, extent.centre, extent.length);
}

}  // namespace

Pieces pieces_of(const Part& part) {
  const mesh::Mesh& mesh = part.mesh;
  const auto n = static_cast<std::size_t>(mesh.n_nodes());
  mesh::DisjointSets sets(n);
  std::vector<char> used(n, 0);
  const auto join = [&](mesh::Index a, mesh::Index b) {
    sets.join(a, b);
    used[static_cast<std::size_t>(a)] = used[static_cast<std::size_t>(b)] = 1;
  };
  for (const auto* blocks : {&mesh.solids, &mesh.shells})
    for (const mesh::CellBlock& block : *blocks)
      for (Index cell = 0; cell < block.nodes.rows(); ++cell)
        for (Index a = 0; a < block.nodes.cols(); ++a) join(block.nodes(cell, a), block.nodes(cell, 0));
  for (const FrameElement& frame : part.frames)
    for (const mesh::Index node : frame.nodes) join(node, frame.nodes.front());
  if (part.matrices)
    for (const auto& [a, b] : part.matrices->pairs) join(a, b);
  for (const DependentDof& constraint : part.dependent)
    for (const auto& [from, c] : constraint.from) sets.join(constraint.dof.node, from.node);
  for (const InterfaceSpec& spec : part.interfaces)
    if (spec.tie == Tie::rigid)
      for (const mesh::Index node : spec.set.nodes) sets.join(node, spec.set.nodes.front());
  for (const Follower& follower : part.followers) {
    for (const auto& [node, C] : follower.from) sets.join(follower.point, node);
    used[static_cast<std::size_t>(follower.point)] = 0;
  }
  Pieces out{.of_node = std::vector<int>(n, -1), .sizes = {}};
  std::map<int, int> number;  // by root
  for (std::size_t node = 0; node < n; ++node) {
    if (!used[node]) continue;
    const int piece =
        number.try_emplace(sets.of(static_cast<mesh::Index>(node)), static_cast<int>(number.size()))
            .first->second;
    if (piece == static_cast<int>(out.sizes.size())) out.sizes.push_back(0);
    out.of_node[node] = piece;
    ++out.sizes[static_cast<std::size_t>(piece)];
  }
  return out;
}

std::vector<int> free_motions_of(const Part& part, const Pieces& pieces) {
  std::vector<int> free;
  const std::vector<std::vector<mesh::Index>> nodes = nodes_of(pieces);
  for (std::size_t piece = 0; piece < nodes.size(); ++piece)
    free.push_back(static_cast<int>(
        left_free(held_by_interfaces(part, pieces, static_cast<int>(piece)), extent_of(part, nodes[piece]))
            .cols()));
  return free;
}

std::vector<mesh::Index> spread_nodes(const mesh::Mesh& mesh, const std::vector<mesh::Index>& among) {
  if (among.empty()) return {};
  const auto x = [&](mesh::Index node) { return Eigen::Vector3d(mesh.points.row(node)); };
  const auto farthest = [&](const auto& distance) { return *std::ranges::max_element(among, {}, distance); };
  const Eigen::Vector3d start = x(among.front());
  const mesh::Index a = farthest([&](mesh::Index node) { return (x(node) - start).norm(); });
  const mesh::Index b = farthest([&](mesh::Index node) { return (x(node) - x(a)).norm(); });
  if (a == b) return {a};
  const Eigen::Vector3d line = (x(b) - x(a)).normalized();
  const auto off = [&](mesh::Index node) { return line.cross(x(node) - x(a)).norm(); };
  const mesh::Index c = farthest(off);
  if (off(c) < 1e-6 * (x(b) - x(a)).norm()) return {a, b};
  return {a, b, c};
}

std::vector<std::string> hold_pieces(Part& part, const Pieces& pieces) {
  std::vector<std::string> names;
  std::vector<char> taken(part.mesh.n_nodes(), 0);
  for (const InterfaceSpec& spec : part.interfaces)
    for (const mesh::Index node : spec.set.nodes) taken[node] = 1;
  for (const DependentDof& constraint : part.dependent) taken[constraint.dof.node] = 1;
  const std::vector<char> turns = nodes_with_rotations(part);
  std::vector<std::vector<mesh::Index>> nodes = nodes_of(pieces);
  for (std::size_t piece = 0; piece < nodes.size(); ++piece) {
    const Extent extent = extent_of(part, nodes[piece]);
    const Motions H = held_by_interfaces(part, pieces, static_cast<int>(piece));
    Eigen::Matrix<double, 6, Eigen::Dynamic> free = left_free(H, extent);
    if (free.cols() == 0) continue;
    std::erase_if(nodes[piece], [&](mesh::Index node) { return taken[node]; });
    const std::string name = fmt::format("piece {}", piece + 1);
    if (const auto at = std::ranges::find_if(nodes[piece], [&](mesh::Index node) { return turns[node]; });
        at != nodes[piece].end()) {
      InterfaceSpec spec{.name = name, .tie = Tie::rigid};
      spec.point = part.mesh.points.row(*at).transpose();
      spec.set.nodes = {*at};
      part.interfaces.push_back(std::move(spec));
      names.push_back(name);
      continue;
    }
    char letter = 'a';
    // Of three nodes the displacements that move most in what the former ones leave free.
    std::map<mesh::Index, std::vector<int>> chosen;
    const std::vector<mesh::Index> spread = spread_nodes(part.mesh, nodes[piece]);
    while (free.cols() > 0) {
      double most = 0.0;
      mesh::Index best = -1;
      int direction = 0;
      for (const mesh::Index node : spread)
        for (int d = 0; d < 3; ++d) {
          const double size = (motion_at(part.mesh.points.row(node)).row(d) * free).norm();
          if (size > most) most = size, best = node, direction = d;
        }
      const double scale =
          (motion_at(extent.centre) * free).norm() + extent.length * free.bottomRows(3).norm();
      if (best < 0 || !(most > 1e-6 * scale))
        throw std::invalid_argument(
            fmt::format("piece {} of the mesh ({} nodes) is free to move, and its nodes lie on a line "
                        "without rotations of "
                        "their own",
                        piece + 1, pieces.sizes[piece]));
      chosen[best].push_back(direction);
      const Eigen::VectorXd row = (motion_at(part.mesh.points.row(best)).row(direction) * free).transpose();
      const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(row).householderQ();
      free = (free * Q.rightCols(free.cols() - 1)).eval();
    }
    for (auto& [node, directions] : chosen) {
      std::ranges::sort(directions);
      InterfaceSpec spec{
          .name = fmt::format("{} {}", name, letter++), .tie = Tie::node, .directions = directions};
      spec.point = part.mesh.points.row(node).transpose();
      spec.set.nodes = {node};
      names.push_back(spec.name);
      part.interfaces.push_back(std::move(spec));
    }
  }
  return names;
}

}  // namespace flexura::reduce
