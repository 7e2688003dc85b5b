// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/idle_turns.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <stdexcept>
#include <vector>

#include "reduce/assembly/tied_model.hpp"
#include "reduce/assembly/ties/pieces.hpp"
#include "reduce/part/idle_moves.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kNothing = 1e-12;  // of a node's largest: what releases leave of stiffness is round-off

// The interface that is this node alone, or null.
const InterfaceSpec* interface_at(const Part& part, mesh::Index node) {
  for (const InterfaceSpec& spec : part.interfaces)
    if (spec.set.nodes.size() == 1 && spec.set.nodes.front() == node &&
        (spec.tie == Tie::rigid || spec.tie == Tie::node))
      return &spec;
  return nullptr;
}

// Nodes whose rotations shells hold, or that follow or lead others.
std::vector<char> busy_nodes(const Part& part) {
  std::vector<char> busy(part.mesh.n_nodes(), 0);
  for (const mesh::CellBlock& block : part.mesh.shells)
    for (Index k = 0; k < block.nodes.size(); ++k) busy[block.nodes.data()[k]] = 1;
  for (const InterfaceSpec& spec : part.interfaces)
    if (spec.tie == Tie::rigid && spec.set.nodes.size() > 1)
      for (const mesh::Index node : spec.set.nodes)
        if (spec.rotations || node == spec.turning_node) busy[node] = 1;
  for (const DependentDof& dependent : part.dependent) {
    if (dependent.dof.direction > 2) busy[dependent.dof.node] = 1;
    for (const auto& [from, c] : dependent.from)
      if (from.direction > 2) busy[from.node] = 1;
  }
  return busy;
}

// v . theta of the node less v . theta of the element, by (u, theta) of the node and of the element's other end.
FrameElement spring_to(const Part& part, mesh::Index node, mesh::Index other, const Vector3d& v,
                       double stiffness) {
  const Vector3d line = (part.mesh.points.row(other) - part.mesh.points.row(node)).transpose();
  Eigen::Matrix<double, 12, 1> q = Eigen::Matrix<double, 12, 1>::Zero();
  q.segment<3>(3) = v;
  if (std::abs(v.dot(line)) < 1e-6 * line.norm()) {
    const Vector3d across = v.cross(line) / line.squaredNorm();  // v . (e x d) / l = (v x e) . d / l
    q.segment<3>(0) = across;
    q.segment<3>(6) = -across;
  } else {
    q.segment<3>(9) = -v;
  }
  return {.nodes = {node, other}, .K = stiffness * q * q.transpose()};
}

// A rotation with mass that nothing resists: of beams without torsion or bending stiffness.
struct HeavyTurn {
  mesh::Index node;
  Vector3d direction;
  double stiffness;
};

// They turn as the body does, or, where its nodes lie on a line and do not tell how it turns about that, with the first.
void hold_heavy_turns(Part& part, const std::vector<HeavyTurn>& turns, std::vector<std::string>& warnings) {
  if (turns.empty()) return;
  const Pieces pieces = pieces_of(part);
  std::vector<std::vector<mesh::Index>> nodes(pieces.sizes.size());
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node)
    if (const int piece = pieces.of_node[static_cast<std::size_t>(node)]; piece >= 0)
      nodes[static_cast<std::size_t>(piece)].push_back(node);
  std::map<int, mesh::Index> first;
  for (const HeavyTurn& turn : turns) {
    const int piece = pieces.of_node[static_cast<std::size_t>(turn.node)];
    const std::vector<mesh::Index> anchors = spread_nodes(part.mesh, nodes[static_cast<std::size_t>(piece)]);
    Eigen::Matrix<double, 6, 1> v;
    v << Vector3d::Zero(), turn.direction;
    const Vector3d line =
        anchors.size() == 2
            ? Vector3d((part.mesh.points.row(anchors[1]) - part.mesh.points.row(anchors[0])).normalized())
            : Vector3d::Zero();
    FrameElement element;
    if (std::abs(turn.direction.dot(line)) > 0.5) {
      const mesh::Index other = first.emplace(piece, turn.node).first->second;
      if (other == turn.node) continue;
      Eigen::Matrix<double, 12, 1> q;
      q << v, -v;
      element = {.nodes = {turn.node, other}, .K = turn.stiffness * q * q.transpose()};
    } else {
      element = following(part, turn.node, v, anchors, turn.stiffness);
    }
    if (!element.nodes.empty()) part.frames.push_back(std::move(element));
  }
  warnings.push_back(
      fmt::format("{} rotations of beams' nodes that nothing resists: what AUTOSPC holds at the "
                  "ground follows the rigid motion of the body here",
                  turns.size()));
}

}  // namespace

void hold_idle_turns(Part& part, std::vector<std::string>& warnings) {
  const std::vector<char> turns = nodes_with_rotations(part), busy = busy_nodes(part);
  const auto n = static_cast<std::size_t>(part.mesh.n_nodes());
  std::vector<Matrix3d> held(n, Matrix3d::Zero()), seen(n, Matrix3d::Zero());
  std::vector<std::vector<mesh::Index>> beside(n);
  for (const FrameElement& frame : part.frames)
    for (std::size_t a = 0; a < frame.nodes.size(); ++a) {
      const auto node = static_cast<std::size_t>(frame.nodes[a]);
      const auto row = 6 * static_cast<Index>(a) + 3;
      held[node] += frame.K.block<3, 3>(row, row);
      for (const mesh::Index other : frame.nodes)
        if (other != frame.nodes[a]) beside[node].push_back(other);
    }
  double most = 0.0;
  for (const Follower& follower : part.followers)
    for (const auto& [node, C] : follower.from) {
      seen[static_cast<std::size_t>(node)] += C.rightCols<3>().transpose() * C.rightCols<3>();
      most = std::max(most, C.rightCols<3>().squaredNorm());
    }
  std::vector<FrameElement> springs;
  std::vector<HeavyTurn> heavy;
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) {
    const auto k = static_cast<std::size_t>(node);
    if (!turns[k] || busy[k] || !(held[k].trace() > 0.0)) continue;
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(0.5 * (held[k] + held[k].transpose()));
    for (Index d = 0; d < 3; ++d) {
      const Vector3d v = axes.eigenvectors().col(d);
      if (axes.eigenvalues()(d) > kNothing * axes.eigenvalues()(2)) continue;
      if (v.dot(seen[k] * v) > kNothing * most) {  // it has mass
        heavy.push_back({node, v, held[k].trace()});
        continue;
      }
      if (const InterfaceSpec* own = interface_at(part, node))
        for (const int direction : own->directions)
          if (direction > 2 && std::abs(v(direction - 3)) > 1e-6)
            throw std::invalid_argument(
                fmt::format("interface '{}': its rotation about {} has neither stiffness nor mass (behind "
                            "pin flags, or of rods alone): leave it "
                            "out of the interface's directions",
                            own->name, "xyz"[direction - 3]));
      mesh::Index partner = -1;
      for (const mesh::Index other : beside[k]) {
        const Vector3d line = (part.mesh.points.row(other) - part.mesh.points.row(node)).transpose();
        const bool across = line.norm() > 0.0 && std::abs(v.dot(line)) < 1e-6 * line.norm();
        if (across || (partner < 0 && turns[static_cast<std::size_t>(other)] && line.norm() > 0.0))
          partner = other;
        if (across) break;
      }
      if (partner >= 0) springs.push_back(spring_to(part, node, partner, v, held[k].trace()));
    }
  }
  part.frames.insert(part.frames.end(), springs.begin(), springs.end());
  hold_heavy_turns(part, heavy, warnings);
}

}  // namespace flexura::reduce
