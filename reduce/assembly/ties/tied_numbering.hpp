// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/linalg/petsc/team.hpp"

namespace flexura::reduce {

/// Which nodes have six dofs: those of shells, and of frame elements that resist their rotation.
std::vector<char> nodes_with_rotations(const Part& part);

/// An interface as its dofs are numbered.
struct InterfaceDofs {
  Tie tie;
  Eigen::Vector3d point;
  std::vector<int> directions;  ///< that are retained: boundary dofs from first_b on
  std::vector<mesh::Index> nodes;
  int first_b = 0;
  std::array<int, 6> code{};  ///< rigid ties: where each direction is: interior dof >= 0, boundary -(b + 1)
};

/// Which displacements and rotations of a part's nodes are dofs, which are boundary dofs, and which follow others (tied_model.hpp
/// has the equations).  Constant once it is built.
class TiedNumbering {
 public:
  using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

  /// Throws std::invalid_argument for cells, ties, followers and constraints that name nodes which are not there or have no such dof.
  explicit TiedNumbering(const Part& part);
  /// The numbering of some nodes of a part, which are its nodes 0, 1, ... then, with the interior dofs that move them and those
  /// of the groups that `with` names (ascending).  Boundary dofs and interfaces are those of all; interfaces know no nodes.
  struct Share;
  Share share(const std::vector<mesh::Index>& nodes, const std::vector<int>& with) const;
  explicit TiedNumbering(linalg::Message& message);  ///< what put() has sent
  void put(linalg::Message& message) const;

  int n_nodes() const { return n_nodes_; }
  double length() const {
    return length_;
  }  ///< of the box around all of the part's nodes, corner to corner [m]
  int n_i() const { return n_i_; }
  int n_b() const { return n_b_; }
  const Points& points() const { return points_; }
  std::int64_t label_of(mesh::Index node) const { return node_label_.empty() ? node : node_label_[node]; }

  int n_interfaces() const { return static_cast<int>(interfaces_.size()); }
  const std::vector<InterfaceDofs>& interfaces() const { return interfaces_; }
  /// First boundary dof of an interface; its retained directions follow.
  int first_dof(int interface) const { return interfaces_[interface].first_b; }
  const std::vector<int>& directions(int interface) const { return interfaces_[interface].directions; }
  const Eigen::Vector3d& point(int interface) const { return interfaces_[interface].point; }

  /// Where displacements are, 3 n_nodes, and a rotation: interior dof >= 0, boundary -(b + 1), or no dof (tied_codes.hpp).
  const std::vector<int>& codes() const { return code_; }
  int code(mesh::Index node, int direction) const {
    return code_[3 * static_cast<std::size_t>(node) + direction];
  }
  int n_rotations() const { return static_cast<int>(rotation_code_.size()); }
  int rotation_of(mesh::Index node) const { return rotation_of_[node]; }  ///< -1: it has none
  const std::array<int, 3>& rotation_code(int rotation) const { return rotation_code_[rotation]; }
  /// Where a direction of a rigid tie's or a single node's interface is.
  int code_of(const InterfaceDofs& interface, int direction) const;

  /// What a point without dofs moves by: u = sum over k of C[k] (dof code[k]).
  struct Followed {
    std::span<const int> code;
    std::span<const Eigen::Vector3d> C;
  };
  bool follows(mesh::Index node) const { return slave_of_[node] >= 0; }
  Followed followed(mesh::Index node) const {
    const int slave = slave_of_[node];
    if (slave < 0) return {};
    const auto first = static_cast<std::size_t>(slave_begin_[slave]),
               count = static_cast<std::size_t>(slave_begin_[slave + 1]) - first;
    return {std::span(slave_code_).subspan(first, count), std::span(slave_C_).subspan(first, count)};
  }
  /// Calls visit(code, u) for every dof that moves a node: the dof, and the displacement for a unit of it.
  template <class Visit>
  void each_dof(mesh::Index node, const Visit& visit) const;  // tied_codes.hpp

  /// Interior dofs by nodes and interface nodes: ascending, first 0, last n_i.
  const std::vector<int>& group_begin() const { return group_begin_; }
  /// Of the interior dofs that a node has, or of those of its tie; -1: none.
  int group_of(mesh::Index node) const {
    return tie_of_[node] >= 0 ? tie_group_[tie_of_[node]] : group_of_[node];
  }
  /// Adds the groups of all that moves or turns the node.
  void add_groups(mesh::Index node, std::vector<int>& groups) const;

 private:
  TiedNumbering() = default;
  void number_dofs(const Part& part);
  void mark_rotations(const Part& part);
  void follow(const Part& part);

  int n_nodes_ = 0, n_i_ = 0, n_b_ = 0;
  double length_ = 0.0;
  Points points_;
  std::vector<std::int64_t> node_label_;
  std::vector<InterfaceDofs> interfaces_;
  std::vector<int> code_;         ///< 3 n_nodes: interior dof >= 0, boundary -(b + 1), or kSlave, kUnused
  std::vector<int> tie_of_;       ///< n_nodes: the rigid tie a node follows, or -1
  std::vector<int> rotation_of_;  ///< n_nodes: place of its rotation, or -1
  std::vector<std::array<int, 3>> rotation_code_;  ///< of each rotation
  // What points without dofs (kSlave) follow: u = sum over k of slave_C_[k] (dof slave_code_[k]).
  std::vector<int> slave_of_;  ///< n_nodes: place in slave_begin_, or -1
  std::vector<int> slave_begin_, slave_code_;
  std::vector<Eigen::Vector3d> slave_C_;
  std::vector<int> group_begin_;
  std::vector<int> group_of_;   ///< n_nodes: group of interior dofs, or -1
  std::vector<int> tie_group_;  ///< group of the interior dofs of an interface node, or -1
};

struct TiedNumbering::Share {
  TiedNumbering numbering;
  std::vector<int> dofs;  ///< of its interior dofs their numbers in the whole part's, ascending
};

}  // namespace flexura::reduce
