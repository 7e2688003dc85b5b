// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/idle_moves.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>

#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/tied_model.hpp"
#include "reduce/assembly/ties/pieces.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

struct IdleMove {
  mesh::Index node;
  Vector3d direction;
};

// Nodes of cells and of interfaces: nothing of them is idle.
std::vector<char> busy_nodes(const Part& part) {
  std::vector<char> busy(part.mesh.n_nodes(), 0);
  for (const auto* blocks : {&part.mesh.solids, &part.mesh.shells})
    for (const mesh::CellBlock& block : *blocks)
      for (Index k = 0; k < block.nodes.size(); ++k) busy[block.nodes.data()[k]] = 1;
  for (const InterfaceSpec& spec : part.interfaces)
    if (spec.tie == Tie::node || spec.tie == Tie::rigid)
      for (const mesh::Index node : spec.set.nodes) busy[node] = 1;
  return busy;
}

std::vector<IdleMove> idle_moves(const Part& part, double& stiffest) {
  constexpr double kNothing = 1e-10;  // of a node's largest: round-off of directions
  std::vector<Matrix3d> held(part.mesh.n_nodes(), Matrix3d::Zero());
  std::vector<char> seen(part.mesh.n_nodes(), 0);
  for (const FrameElement& frame : part.frames)
    for (std::size_t a = 0; a < frame.nodes.size(); ++a) {
      const auto row = 6 * static_cast<Index>(a);
      held[frame.nodes[a]] += frame.K.block<3, 3>(row, row);
      seen[frame.nodes[a]] = 1;
    }
  for (const Matrix3d& own : held) stiffest = std::max(stiffest, own.trace());
  // What follows others or leads them is held by that.
  const auto hold = [&](const NodalDof& dof) {
    if (dof.direction < 3) held[dof.node](dof.direction, dof.direction) += stiffest;
  };
  for (const DependentDof& dependent : part.dependent) {
    hold(dependent.dof);
    for (const auto& [from, c] : dependent.from) hold(from);
  }
  const std::vector<char> busy = busy_nodes(part);
  std::vector<IdleMove> idle;
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) {
    if (!seen[node] || busy[node]) continue;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(0.5 * (held[node] + held[node].transpose()));
    for (Index d = 0; d < 3; ++d)
      if (!(axes.eigenvalues()(d) > kNothing * axes.eigenvalues()(2)))
        idle.push_back({node, axes.eigenvectors().col(d)});
  }
  return idle;
}

// Of each piece: nodes without idle moves where there are three such off a line, any others otherwise.
std::vector<std::vector<mesh::Index>> anchors_of(const Part& part, const Pieces& pieces,
                                                 const std::vector<IdleMove>& idle) {
  std::vector<std::vector<mesh::Index>> firm(pieces.sizes.size()), all(pieces.sizes.size());
  std::vector<char> is_idle(part.mesh.n_nodes(), 0);
  for (const IdleMove& move : idle) is_idle[move.node] = 1;
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) {
    const int piece = pieces.of_node[static_cast<std::size_t>(node)];
    if (piece < 0) continue;
    all[static_cast<std::size_t>(piece)].push_back(node);
    if (!is_idle[node]) firm[static_cast<std::size_t>(piece)].push_back(node);
  }
  std::vector<std::vector<mesh::Index>> anchors;
  for (std::size_t piece = 0; piece < all.size(); ++piece) {
    anchors.push_back(spread_nodes(part.mesh, firm[piece]));
    if (anchors.back().size() < 3) anchors.back() = spread_nodes(part.mesh, all[piece]);
  }
  return anchors;
}

}  // namespace

FrameElement following(const Part& part, mesh::Index node, const Eigen::Matrix<double, 6, 1>& v,
                       const std::vector<mesh::Index>& anchors, double stiffness) {
  const auto n = static_cast<Index>(anchors.size());
  const Vector3d centre = part.mesh.points.row(anchors.front());
  Eigen::MatrixXd H(3 * n, 6);
  double reach = 0.0;
  for (Index k = 0; k < n; ++k) {
    const Vector3d r = Vector3d(part.mesh.points.row(anchors[static_cast<std::size_t>(k)])) - centre;
    H.middleRows<3>(3 * k) = motion_at(r);
    reach = std::max(reach, r.norm());
  }
  if (!(reach > 0.0)) reach = 1.0;
  H.rightCols<3>() /= reach;
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(H, Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(1e-6);
  Eigen::Matrix<double, 6, 6> there = node_motion_at(Vector3d(part.mesh.points.row(node)) - centre);
  there.rightCols<3>() /= reach;
  const Eigen::RowVectorXd of_anchors =
      v.transpose() * there * svd.solve(Eigen::MatrixXd::Identity(3 * n, 3 * n));
  FrameElement element{.nodes = anchors, .K = {}};
  const auto at = std::ranges::find(element.nodes, node) - element.nodes.begin();
  if (at == std::ssize(element.nodes)) element.nodes.push_back(node);
  Eigen::VectorXd q = Eigen::VectorXd::Zero(6 * std::ssize(element.nodes));
  for (Index k = 0; k < n; ++k) q.segment<3>(6 * k) = -of_anchors.segment<3>(3 * k).transpose();
  q.segment<6>(6 * at) += v;
  for (double& c : q)
    if (std::abs(c) < 1e-10 * q.cwiseAbs().maxCoeff() || std::abs(c) < 1e-12) c = 0.0;  // round-off
  if (q.isZero(0.0)) return {};
  element.K = stiffness * q * q.transpose();
  return element;
}

void hold_idle_moves(Part& part, std::vector<std::string>& warnings) {
  double stiffest = 0.0;
  const std::vector<IdleMove> idle = idle_moves(part, stiffest);
  if (idle.empty()) return;
  const Pieces pieces = pieces_of(part);
  const std::vector<std::vector<mesh::Index>> anchors = anchors_of(part, pieces, idle);
  std::vector<FrameElement> elements;
  std::size_t nodes = 0;
  mesh::Index last = -1;
  // The other end of its rod, where that has rotations: it carries the node as an arm.
  const std::vector<char> turns = nodes_with_rotations(part);
  std::map<mesh::Index, mesh::Index> arm;
  for (const FrameElement& frame : part.frames)
    for (const mesh::Index a : frame.nodes)
      for (const mesh::Index b : frame.nodes)
        if (a != b && turns[b] && !turns[a]) arm.emplace(a, b);
  for (const IdleMove& move : idle) {
    if (move.node != last) ++nodes, last = move.node;
    if (const auto at = arm.find(move.node); at != arm.end()) {
      const Vector3d r = (part.mesh.points.row(move.node) - part.mesh.points.row(at->second)).transpose();
      Eigen::Matrix<double, 12, 1> q;
      q << move.direction, Vector3d::Zero(), -(motion_at(r).transpose() * move.direction);
      elements.push_back({.nodes = {move.node, at->second}, .K = stiffest * q * q.transpose()});
      continue;
    }
    FrameElement element = following(
        part, move.node, (Eigen::Matrix<double, 6, 1>() << move.direction, Vector3d::Zero()).finished(),
        anchors[static_cast<std::size_t>(pieces.of_node[static_cast<std::size_t>(move.node)])], stiffest);
    if (!element.nodes.empty()) elements.push_back(std::move(element));
  }
  const mesh::Index first = idle.front().node;
  warnings.push_back(fmt::format(
      "{} node{} (the first is {}) can move across {} rods or springs without strain: what AUTOSPC holds at "
      "the "
      "ground follows the rigid motion of the body here",
      nodes, nodes == 1 ? "" : "s", part.mesh.node_label.empty() ? first + 1 : part.mesh.node_label[first],
      nodes == 1 ? "its" : "their"));
  part.frames.insert(part.frames.end(), std::make_move_iterator(elements.begin()),
                     std::make_move_iterator(elements.end()));
}

}  // namespace flexura::reduce
