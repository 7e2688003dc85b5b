// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/part/deck_averages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>

#include "reduce/assembly/input/average.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/tied_model.hpp"

namespace flexura::reduce {
namespace {

using Eigen::Index;

bool uses(const FrameElement& frame, mesh::Index node) {
  return std::ranges::find(frame.nodes, node) != frame.nodes.end();
}

bool uses(const Follower& follower, mesh::Index node) {
  return std::ranges::any_of(follower.from, [&](const auto& from) { return from.first == node; });
}

bool in_cells(const mesh::Mesh& mesh, mesh::Index node) {
  for (const auto* blocks : {&mesh.solids, &mesh.shells})
    for (const mesh::CellBlock& block : *blocks)
      if ((block.nodes.array() == node).any()) return true;
  return false;
}

// The frames that hang on the node as one, with the nodes of the set in its place.
FrameElement spread(const std::vector<FrameElement>& frames, mesh::Index node, const InterfaceSpec& average,
                    const Eigen::Matrix<double, 6, Eigen::Dynamic>& map) {
  FrameElement out;
  std::map<mesh::Index, Index> place;
  const auto take = [&](mesh::Index other) {
    if (place.emplace(other, static_cast<Index>(out.nodes.size())).second) out.nodes.push_back(other);
  };
  for (const FrameElement& frame : frames)
    for (const mesh::Index other : frame.nodes)
      if (other != node) take(other);
  for (const mesh::Index other : average.set.nodes) take(other);
  const auto n = static_cast<Index>(out.nodes.size());
  out.K.setZero(6 * n, 6 * n);
  for (const FrameElement& frame : frames) {
    Eigen::MatrixXd T = Eigen::MatrixXd::Zero(frame.K.rows(), 6 * n);
    for (std::size_t a = 0; a < frame.nodes.size(); ++a) {
      const auto row = 6 * static_cast<Index>(a);
      if (frame.nodes[a] != node) {
        T.block<6, 6>(row, 6 * place.at(frame.nodes[a])).setIdentity();
        continue;
      }
      for (std::size_t k = 0; k < average.set.nodes.size(); ++k)
        T.block<6, 3>(row, 6 * place.at(average.set.nodes[k])) +=
            map.middleCols<3>(3 * static_cast<Index>(k));
    }
    const auto add = [&](const Eigen::MatrixXd& from, Eigen::MatrixXd& to) {
      if (from.size() == 0) return;
      if (to.size() == 0) to.setZero(6 * n, 6 * n);
      to += T.transpose() * from * T;
      to = (0.5 * (to + to.transpose())).eval();
    };
    add(frame.K, out.K);
    add(frame.D, out.D);
    add(frame.K_loss, out.K_loss);
  }
  return out;
}

// Whether the frames strain under one of these dofs of the node.
bool hold(const std::vector<FrameElement>& frames, mesh::Index node, const std::array<bool, 6>& given) {
  for (const FrameElement& frame : frames)
    for (std::size_t a = 0; a < frame.nodes.size(); ++a)
      for (Index d = 0; d < 6; ++d)
        if (frame.nodes[a] == node && !given[static_cast<std::size_t>(d)] &&
            !frame.K.row(6 * static_cast<Index>(a) + d).isZero(0.0))
          return true;
  return false;
}

// Whether the map gives this motion of the reference node back where the set moves with it: not what a line leaves open.
bool tells(const mesh::Mesh& mesh, const InterfaceSpec& average,
           const Eigen::Matrix<double, 6, Eigen::Dynamic>& map, Index d) {
  Eigen::VectorXd u(map.cols());
  for (std::size_t k = 0; k < average.set.nodes.size(); ++k)
    u.segment<3>(3 * static_cast<Index>(k)) =
        motion_at(mesh.points.row(average.set.nodes[k]).transpose() - average.point).col(d);
  return std::abs((map * u)(d)-1.0) < 1e-6;  // 0 or 1, but for round-off
}

}  // namespace

void spread_averages(const std::vector<DeckTie>& ties, Part& part, std::vector<std::string>& notes) {
  constexpr std::size_t kMost = 1000;
  for (const DeckTie& tie : ties) {
    if (tie.spec.tie != Tie::average) continue;
    const mesh::Index node = tie.spec.turning_node;
    std::vector<FrameElement> frames;
    for (const FrameElement& frame : part.frames)
      if (uses(frame, node)) frames.push_back(frame);
    const bool points = std::ranges::any_of(part.followers, [&](const Follower& f) { return uses(f, node); });
    const bool solid = in_cells(part.mesh, node);
    if (frames.empty() && !points && !solid) continue;
    if (solid)
      throw std::invalid_argument(
          fmt::format("{} (RBE3): its reference node {} belongs to solid or shell elements, which is not "
                      "read: give it a node of its own and "
                      "tie that to theirs by RBE2",
                      tie.spec.name, tie.node));
    if (hold(frames, node, tie.dofs))
      throw std::invalid_argument(
          fmt::format("{} (RBE3) gives only some of the six motions of its reference node {}, of which "
                      "elements there hold others: name "
                      "123456 in REFC",
                      tie.spec.name, tie.node));
    if (tie.spec.set.nodes.size() > kMost)
      throw std::invalid_argument(
          fmt::format("{} (RBE3) carries elements on {} nodes; at most {} are read: tie fewer of them",
                      tie.spec.name, tie.spec.set.nodes.size(), kMost));
    const Eigen::Matrix<double, 6, Eigen::Dynamic> map = averaging_map(part.mesh, tie.spec);
    std::array<bool, 6> told{};
    for (Index d = 0; d < 6; ++d) told[static_cast<std::size_t>(d)] = tells(part.mesh, tie.spec, map, d);
    if (hold(frames, node, told))
      throw std::invalid_argument(
          fmt::format("{} (RBE3): its {} nodes lie in a point or on a line and do not tell how its reference "
                      "node {} turns, which elements "
                      "there hold: add a node off the line",
                      tie.spec.name, tie.spec.set.nodes.size(), tie.node));
    std::erase_if(part.frames, [&](const FrameElement& frame) { return uses(frame, node); });
    if (!frames.empty()) part.frames.push_back(spread(frames, node, tie.spec, map));
    for (Follower& follower : part.followers) {
      const auto found = std::ranges::find(follower.from, node, [](const auto& from) { return from.first; });
      if (found == follower.from.end()) continue;
      const Eigen::Matrix<double, 3, 6> C = found->second;
      follower.from.erase(found);
      for (const auto& [other, of_other] : follower_of(follower.point, C, tie.spec, map).from) {
        const auto same =
            std::ranges::find(follower.from, other, [](const auto& from) { return from.first; });
        if (same == follower.from.end())
          follower.from.emplace_back(other, of_other);
        else
          same->second += of_other;
      }
    }
    notes.push_back(fmt::format("{} (RBE3): the elements at node {} hang on the mean motion of its {} nodes",
                                tie.spec.name, tie.node, tie.spec.set.nodes.size()));
  }
}

}  // namespace flexura::reduce
