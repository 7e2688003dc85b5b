// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/whole_body.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/tied_model.hpp"
#include "reduce/elements/element.hpp"
#include "reduce/elements/shell.hpp"

namespace flexura::reduce {

using Eigen::Index;

namespace {

// Each node's share of the volume of its cells, all of a cell's alike: positive for every element.
std::vector<double> nodal_volumes(const Part& part) {
  std::vector<double> volume(part.mesh.n_nodes(), 0.0);
  for (const mesh::CellBlock& block : part.mesh.solids) {
    const TabulatedRule& rule = solid_element(block.type).mass;
    NodePositions x(block.nodes.cols(), 3);
    for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
      for (Index a = 0; a < x.rows(); ++a) x.row(a) = part.mesh.points.row(block.nodes(cell, a));
      double whole = 0.0;
      for (const TabulatedRule::Point& point : rule.points)
        whole += point.weight * (point.dN.transpose() * x).determinant();
      for (const mesh::Index node : block.nodes.row(cell))
        volume[node] += whole / static_cast<double>(x.rows());
    }
  }
  for (const mesh::CellBlock& block : part.mesh.shells) {
    NodePositions x(block.nodes.cols(), 3);
    for (Index cell = 0; cell < block.nodes.rows(); ++cell) {
      for (Index a = 0; a < x.rows(); ++a) x.row(a) = part.mesh.points.row(block.nodes(cell, a));
      const double whole = shell_frame(x).area * block.thickness[cell];
      for (const mesh::Index node : block.nodes.row(cell))
        volume[node] += whole / static_cast<double>(x.rows());
    }
  }
  if (part.mesh.solids.empty() && part.mesh.shells.empty())  // beams alone: their nodes count alike
    for (const FrameElement& frame : part.frames)
      for (const mesh::Index node : frame.nodes) volume[node] = 1.0;
  if (part.matrices)  // no cells: every node that has mass counts alike
    for (std::size_t k = 0; k < part.matrices->pairs.size(); ++k)
      if (const auto& [a, b] = part.matrices->pairs[k]; a == b && part.matrices->m[k] > 0.0) volume[a] = 1.0;
  for (const Follower& follower : part.followers) volume[follower.point] = 0.0;
  return volume;
}

// Whether the nodes' displacements tell all six rigid motions.
bool spans_turns(const mesh::Mesh& mesh, const InterfaceSpec& body) {
  if (body.set.nodes.size() < 3) return false;
  Eigen::Matrix<double, Eigen::Dynamic, 6> H(3 * static_cast<Index>(body.set.nodes.size()), 6);
  double reach = 0.0;
  for (std::size_t a = 0; a < body.set.nodes.size(); ++a) {
    const Eigen::Vector3d x = mesh.points.row(body.set.nodes[a]);
    H.middleRows<3>(3 * static_cast<Index>(a)) = motion_at(x);
    reach = std::max(reach, (x - body.point).norm());
  }
  return free_motions(H, body.point, std::max(reach, 1e-300)).cols() == 0;
}

}  // namespace

int free_rigid_motions(const Part& part) {
  std::vector<Vector6> rows;
  for (const InterfaceSpec& spec : part.interfaces) {
    const Eigen::Vector3d point = spec.tie == Tie::node && spec.set.nodes.size() == 1
                                      ? Eigen::Vector3d(part.mesh.points.row(spec.set.nodes.front()))
                                      : spec.point;
    for (const int direction : spec.directions)
      if (direction >= 0 && direction < 6)
        rows.emplace_back(node_motion_at(point).row(direction).transpose());
  }
  if (rows.empty()) return 6;
  Eigen::Matrix<double, Eigen::Dynamic, 6> H(static_cast<Index>(rows.size()), 6);
  for (std::size_t k = 0; k < rows.size(); ++k) H.row(static_cast<Index>(k)) = rows[k].transpose();
  const Eigen::RowVector3d low = part.mesh.points.colwise().minCoeff(),
                           high = part.mesh.points.colwise().maxCoeff();
  return static_cast<int>(
      free_motions(H, 0.5 * (low + high).transpose(), std::max(0.5 * (high - low).norm(), 1e-300)).cols());
}

std::string hold_whole_body(Part& part) {
  if (part.mesh.n_nodes() == 0 || free_rigid_motions(part) == 0) return "";
  std::vector<char> taken(part.mesh.n_nodes(), 0);
  std::string name = "body";
  for (const InterfaceSpec& spec : part.interfaces) {
    for (const mesh::Index node : spec.set.nodes) taken[node] = 1;
    if (spec.name == name) name = "whole_body";
  }
  const std::vector<double> volume = nodal_volumes(part);
  InterfaceSpec body{.name = name, .tie = Tie::average};
  double whole = 0.0;
  for (mesh::Index node = 0; node < part.mesh.n_nodes(); ++node) {
    if (taken[node] || !(volume[node] > 0.0)) continue;
    body.set.nodes.push_back(node);
    body.weights.push_back(volume[node]);
    body.point += volume[node] * part.mesh.points.row(node).transpose();
    whole += volume[node];
  }
  if (whole > 0.0) body.point /= whole;
  if (!spans_turns(part.mesh, body)) {
    // Nodes on a line do not say how the body turns about it; one that has rotations of its own does.
    const std::vector<char> turns = nodes_with_rotations(part);
    const auto nearest = std::ranges::min_element(body.set.nodes, {}, [&](mesh::Index node) {
      return turns[node] ? (part.mesh.points.row(node).transpose() - body.point).norm()
                         : std::numeric_limits<double>::infinity();
    });
    if (nearest == body.set.nodes.end() || !turns[*nearest])
      throw std::invalid_argument(
          "the interfaces leave the body free to move, and its other nodes lie on a line without rotations "
          "of their own: retain "
          "more directions");
    body.tie = Tie::rigid;
    body.point = part.mesh.points.row(*nearest).transpose();
    body.set.nodes = {*nearest};
    body.weights.clear();
  }
  part.interfaces.push_back(std::move(body));
  return name;
}

}  // namespace flexura::reduce
