// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/ties/tied_numbering.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/ties/tied_codes.hpp"

namespace flexura::reduce {

TiedNumbering::TiedNumbering(const Part& part)
    : n_nodes_(part.mesh.n_nodes()), points_(part.mesh.points), node_label_(part.mesh.node_label) {
  if (n_nodes_ > 0) length_ = (points_.colwise().maxCoeff() - points_.colwise().minCoeff()).norm();
  number_dofs(part);
}

// Interior dofs run by nodes in the mesh's order, then come those of interface nodes whose directions are not
// retained.
void TiedNumbering::number_dofs(const Part& part) {
  code_.assign(3 * static_cast<std::size_t>(n_nodes_), kUnused);
  tie_of_.assign(n_nodes_, -1);
  rotation_of_.assign(n_nodes_, -1);
  slave_of_.assign(n_nodes_, -1);
  group_of_.assign(n_nodes_, -1);
  for (const mesh::CellBlock& block : part.mesh.solids)
    for (Eigen::Index k = 0; k < block.nodes.size(); ++k) {
      const mesh::Index node = block.nodes.data()[k];
      if (node < 0 || node >= n_nodes_)
        throw std::invalid_argument(
            fmt::format("a cell refers to node {}, but the mesh has nodes 0 to {}", node, n_nodes_ - 1));
      std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kPending);
    }
  if (part.matrices) {
    std::fill(code_.begin(), code_.end(), kUnused);
    for (const auto& pair : part.matrices->pairs)
      for (const mesh::Index node : pair)
        std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kPending);
  }
  mark_rotations(part);
  for (const Follower& follower : part.followers)
    std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(follower.point), 3, kSlave);
  // Nodes that carry only a mass or a link's end follow their rigid tie.
  std::vector<char> carries(n_nodes_, 0);
  for (const NodalMass& mass : part.masses) carries[mass.node] = 1;
  for (const Link& link : part.links) carries[link.from] = carries[link.to] = 1;
  for (const InterfaceSpec& spec : part.interfaces)
    if (spec.tie == Tie::rigid)
      for (const mesh::Index node : spec.set.nodes)
        if (node >= 0 && node < n_nodes_ && carries[node])
          std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kPending);
  for (int node = 0; node < n_nodes_; ++node)
    if (carries[node] && code_[3 * static_cast<std::size_t>(node)] == kUnused)
      throw std::invalid_argument(fmt::format(
          "a point mass, spring or damper is at node {}, which belongs to no cell of the mesh and "
          "to no rigid tie",
          node_label_.empty() ? node : node_label_[node]));
  for (const InterfaceSpec& spec : part.interfaces) {
    // Nothing said of its modes, an elastic tie is an average.
    InterfaceDofs dofs{
        spec.tie == Tie::elastic ? Tie::average : spec.tie, spec.point, spec.directions, {}, n_b_, {}};
    for (mesh::Index node : spec.set.nodes) {
      if (node < 0 || node >= n_nodes_)
        throw std::invalid_argument(
            fmt::format("interface '{}' refers to node {}, but the mesh has nodes 0 to {}", spec.name, node,
                        n_nodes_ - 1));
      if (code_[3 * static_cast<std::size_t>(node)] != kUnused) dofs.nodes.push_back(node);
    }
    if (!std::is_sorted(dofs.directions.begin(), dofs.directions.end()) ||
        std::adjacent_find(dofs.directions.begin(), dofs.directions.end()) != dofs.directions.end())
      throw std::invalid_argument(
          fmt::format("interface '{}': list each direction once, in ascending order", spec.name));
    n_b_ += static_cast<int>(dofs.directions.size());
    interfaces_.push_back(std::move(dofs));
  }
  for (std::size_t k = 0; k < interfaces_.size(); ++k) {
    InterfaceDofs& interface = interfaces_[k];
    if (interface.tie == Tie::rigid)
      for (mesh::Index node : interface.nodes) {
        tie_of_[node] = static_cast<int>(k);
        std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kSlave);
        if (const int r = rotation_of_[node];
            r >= 0 && (part.interfaces[k].rotations || node == part.interfaces[k].turning_node))
          rotation_code_[r].fill(kSlave);
      }
    if (interface.tie == Tie::node && interface.nodes.size() == 1) {
      const mesh::Index node = interface.nodes[0];
      interface.point = points_.row(node);
      int b = interface.first_b;
      for (int direction : interface.directions)
        if (direction < 3)
          code_[3 * static_cast<std::size_t>(node) + direction] = boundary_code(b++);
        else if (const int r = rotation_of_[node]; r >= 0)
          rotation_code_[r][direction - 3] = boundary_code(b++);
    }
  }
  for (const DependentDof& constraint : part.dependent) {
    const auto [node, direction] = constraint.dof;
    const int r = rotation_of_[node];
    int* code = direction < 3 ? &code_[3 * static_cast<std::size_t>(node) + direction]
                : r >= 0      ? &rotation_code_[r][direction - 3]
                              : nullptr;
    if (!code || (*code != kPending && *code != kUnused))
      throw std::invalid_argument(fmt::format("a constraint binds direction {} of node {}, which {}",
                                              direction + 1, node_label_.empty() ? node : node_label_[node],
                                              code ? "follows something else" : "has no rotations"));
    *code = kSlave;
    for (const auto& [from, coefficient] :
         constraint.from)  // a node of constraints alone has the dofs that they name
      if (from.direction < 3)
        if (int& own = code_[3 * static_cast<std::size_t>(from.node) + from.direction]; own == kUnused)
          own = kPending;
  }
  group_begin_ = {0};
  const auto close_group = [this]() -> int {
    if (n_i_ == group_begin_.back()) return -1;
    group_begin_.push_back(n_i_);
    return static_cast<int>(group_begin_.size()) - 2;
  };
  for (int node = 0; node < n_nodes_; ++node) {
    for (int a = 0; a < 3; ++a)
      if (int& code = code_[3 * static_cast<std::size_t>(node) + a]; code == kPending) code = n_i_++;
    if (const int r = rotation_of_[node]; r >= 0)
      for (int& code : rotation_code_[r])
        if (code == kPending) code = n_i_++;
    group_of_[node] = close_group();
  }
  for (InterfaceDofs& interface : interfaces_) {
    interface.code.fill(kUnused);
    int b = interface.first_b;
    for (int direction : interface.directions) interface.code[direction] = boundary_code(b++);
    if (interface.tie == Tie::rigid)
      for (int& code : interface.code)
        if (code == kUnused) code = n_i_++;
    tie_group_.push_back(close_group());
  }
  for (const InterfaceDofs& interface : interfaces_)
    for (const mesh::Index node : interface.nodes)
      if (const int r = rotation_of_[node];
          interface.tie == Tie::rigid && r >= 0 && rotation_code_[r][0] == kSlave)
        std::copy_n(interface.code.begin() + 3, 3, rotation_code_[r].begin());
  for (const DependentDof& constraint : part.dependent) {
    if (constraint.dof.direction < 3) continue;
    const NodalDof& from = constraint.from.at(0).first;
    const int r = rotation_of_[from.node];
    if (r < 0 || from.direction < 3)
      throw std::invalid_argument(fmt::format("a constraint names the rotation of node {}, which has none",
                                              node_label_.empty() ? from.node : node_label_[from.node]));
    rotation_code_[rotation_of_[constraint.dof.node]][constraint.dof.direction - 3] =
        rotation_code_[r][from.direction - 3];
  }
  follow(part);
}

std::vector<char> nodes_with_rotations(const Part& part) {
  std::vector<char> turns(part.mesh.n_nodes(), 0);
  for (const mesh::CellBlock& block : part.mesh.shells)
    for (Eigen::Index k = 0; k < block.nodes.size(); ++k) turns[block.nodes.data()[k]] = 1;
  for (const FrameElement& frame : part.frames)
    for (std::size_t a = 0; a < frame.nodes.size(); ++a)
      if (!frame.K.middleRows<3>(6 * static_cast<Eigen::Index>(a) + 3).isZero(0.0)) turns[frame.nodes[a]] = 1;
  return turns;
}

void TiedNumbering::mark_rotations(const Part& part) {
  const auto check = [this](mesh::Index node) {
    if (node < 0 || node >= n_nodes_)
      throw std::invalid_argument(
          fmt::format("an element refers to node {}, but the mesh has nodes 0 to {}", node, n_nodes_ - 1));
    std::fill_n(code_.begin() + 3 * static_cast<std::ptrdiff_t>(node), 3, kPending);
  };
  for (const mesh::CellBlock& block : part.mesh.shells)
    for (Eigen::Index k = 0; k < block.nodes.size(); ++k) check(block.nodes.data()[k]);
  for (const FrameElement& frame : part.frames)
    for (const mesh::Index node : frame.nodes) check(node);
  const std::vector<char> turns = nodes_with_rotations(part);
  for (int node = 0; node < n_nodes_; ++node) {
    if (!turns[node]) continue;
    rotation_of_[node] = static_cast<int>(rotation_code_.size());
    rotation_code_.push_back({kPending, kPending, kPending});
  }
}

// The points without dofs, by what they follow.
void TiedNumbering::follow(const Part& part) {
  slave_begin_ = {0};
  const auto add = [this](int code, const Eigen::Vector3d& C) {
    for (std::size_t k = slave_begin_.back(); k < slave_code_.size(); ++k)
      if (slave_code_[k] == code) {
        slave_C_[k] += C;
        return;
      }
    slave_code_.push_back(code);
    slave_C_.push_back(C);
  };
  // Of a node's own displacement and rotation by C.
  const auto add_node = [&](mesh::Index node, const Eigen::Matrix<double, 3, 6>& C) {
    if (const int tie = tie_of_[node], slave = slave_of_[node]; tie < 0 && slave >= 0) {
      for (int k = slave_begin_[slave]; k < slave_begin_[slave + 1]; ++k)
        add(slave_code_[k], Eigen::Vector3d(C.leftCols<3>() * slave_C_[k]));
    } else if (tie >= 0) {
      const Eigen::Matrix<double, 3, 6> motion =
          C.leftCols<3>() * motion_at(points_.row(node).transpose() - interfaces_[tie].point);
      for (int d = 0; d < 6; ++d) add(interfaces_[tie].code[d], motion.col(d));
    } else {
      for (int d = 0; d < 3; ++d) add(code_[3 * static_cast<std::size_t>(node) + d], C.col(d));
    }
    const int r = rotation_of_[node];
    for (int d = 0; d < 3 && r >= 0; ++d) add(rotation_code_[r][d], C.col(3 + d));
  };
  const auto close = [this](mesh::Index point) {
    slave_of_[point] = static_cast<int>(slave_begin_.size()) - 1;
    slave_begin_.push_back(static_cast<int>(slave_code_.size()));
  };
  for (int node = 0; node < n_nodes_; ++node) {
    if (tie_of_[node] < 0) continue;
    const InterfaceDofs& interface = interfaces_[tie_of_[node]];
    const Eigen::Matrix<double, 3, 6> motion = motion_at(points_.row(node).transpose() - interface.point);
    for (int d = 0; d < 6; ++d) add(interface.code[d], motion.col(d));
    close(node);
  }
  // Nodes of which constraints bind a displacement; the others are their own.
  for (std::size_t k = 0; k < part.dependent.size();) {
    const mesh::Index node = part.dependent[k].dof.node;
    for (int d = 0; d < 3; ++d)
      if (const int code = code_[3 * static_cast<std::size_t>(node) + d]; is_dof(code))
        add(code, Eigen::Vector3d::Unit(d));
    bool binds = false;
    for (; k < part.dependent.size() && part.dependent[k].dof.node == node; ++k) {
      const DependentDof& constraint = part.dependent[k];
      if (constraint.dof.direction > 2) continue;
      binds = true;
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(constraint.dof.direction);
      for (const auto& [from, c] : constraint.from) {
        const int tie = tie_of_[from.node], r = rotation_of_[from.node];
        if (from.direction < 3 && tie >= 0) {
          const Eigen::Matrix<double, 3, 6> motion =
              motion_at(points_.row(from.node).transpose() - interfaces_[tie].point);
          for (int e = 0; e < 6; ++e) add(interfaces_[tie].code[e], c * motion(from.direction, e) * unit);
          continue;
        }
        if (from.direction > 2 && r < 0)
          throw std::invalid_argument(
              fmt::format("a constraint names the rotation of node {}, which has none",
                          node_label_.empty() ? from.node : node_label_[from.node]));
        add(from.direction < 3 ? code_[3 * static_cast<std::size_t>(from.node) + from.direction]
                               : rotation_code_[r][from.direction - 3],
            c * unit);
      }
    }
    if (!binds) {  // only rotations: it has its own displacements
      slave_code_.resize(static_cast<std::size_t>(slave_begin_.back()));
      slave_C_.resize(static_cast<std::size_t>(slave_begin_.back()));
      continue;
    }
    close(node);
  }
  for (const Follower& follower : part.followers) {
    if (slave_of_[follower.point] >= 0)
      throw std::invalid_argument(fmt::format("point {} follows two things", follower.point));
    for (const auto& [node, C] : follower.from) {
      const bool moves = slave_of_[node] >= 0 || is_dof(code_[3 * static_cast<std::size_t>(node)]);
      if (!moves || (rotation_of_[node] < 0 && !C.rightCols<3>().isZero(0.0)))
        throw std::invalid_argument(fmt::format("a point follows node {}, which has no {}",
                                                node_label_.empty() ? node : node_label_[node],
                                                moves ? "rotation: no shell and no beam holds it" : "dofs"));
      add_node(node, C);
    }
    close(follower.point);
  }
}

int TiedNumbering::code_of(const InterfaceDofs& interface, int d) const {
  if (interface.tie != Tie::node) return interface.code[d];
  const mesh::Index node = interface.nodes[0];
  if (d < 3) return code(node, d);
  return rotation_of_[node] >= 0 ? rotation_code_[rotation_of_[node]][d - 3] : kUnused;
}

// A node of a rigid tie can have a rotation of its own beside what it follows.
void TiedNumbering::add_groups(mesh::Index node, std::vector<int>& groups) const {
  for (const int group : {tie_of_[node] >= 0 ? tie_group_[tie_of_[node]] : -1, group_of_[node]})
    if (group >= 0 && std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  // What the dofs of a node follow by constraints.
  const int slave = tie_of_[node] < 0 ? slave_of_[node] : -1;
  for (int k = slave >= 0 ? slave_begin_[slave] : 0; slave >= 0 && k < slave_begin_[slave + 1]; ++k) {
    if (slave_code_[k] < 0) continue;
    const auto next = std::upper_bound(group_begin_.begin(), group_begin_.end(), slave_code_[k]);
    const int group = static_cast<int>(next - group_begin_.begin()) - 1;
    if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
  }
  if (const int r = rotation_of_[node]; r >= 0)  // a rotation can be another node's
    for (const int code : rotation_code_[r]) {
      if (code < 0) continue;
      const auto next = std::upper_bound(group_begin_.begin(), group_begin_.end(), code);
      const int group = static_cast<int>(next - group_begin_.begin()) - 1;
      if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
    }
}

}  // namespace flexura::reduce
