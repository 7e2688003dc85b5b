// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "reduce/assembly/input/part.hpp"

namespace flexura::reduce {

/// Which nodes have six dofs: those of shells, and of frame elements that resist their rotation.
std::vector<char> nodes_with_rotations(const Part& part);

/// Which displacements and rotations of a part's nodes are dofs, which are boundary dofs, and which follow others (tied_model.hpp
/// has the equations).
class TiedNumbering {
 public:
  int n_nodes() const { return n_nodes_; }
  int n_i() const { return n_i_; }
  int n_b() const { return n_b_; }
  int n_interfaces() const { return static_cast<int>(interfaces_.size()); }

  /// Interior dofs by nodes: ascending, first 0, last n_i.
  const std::vector<int>& group_begin() const { return group_begin_; }
  int n_rotations() const { return static_cast<int>(rotation_code_.size()); }
  int rotation_of(mesh::Index node) const { return rotation_of_[node]; }  ///< -1: it has none

  /// First boundary dof of an interface; its retained directions follow.
  int first_dof(int interface) const { return interfaces_[interface].first_b; }
  const std::vector<int>& directions(int interface) const { return interfaces_[interface].directions; }
  const Eigen::Vector3d& point(int interface) const { return interfaces_[interface].point; }

 protected:
  /// Nothing is numbered yet.
  TiedNumbering() = default;
  /// Throws std::invalid_argument for cells, ties, followers and constraints that name nodes which are not there or have no such dof.
  explicit TiedNumbering(const Part& part);

  struct InterfaceDofs {
    Tie tie;
    Eigen::Vector3d point;
    std::vector<int> directions;
    std::vector<mesh::Index> nodes;
    int first_b = 0;
    std::array<int, 6> code{};  ///< rigid ties: where each direction is: interior dof >= 0, boundary -(b + 1)
    Eigen::Matrix<double, 6, Eigen::Dynamic>
        average;  ///< averaging ties: u, theta of the set's displacements
  };

  void add_groups(int node, std::vector<int>& groups) const;
  /// Calls visit(code, u) for every dof that moves a node: the dof, and the displacement for a unit of it.
  template <class Visit>
  void each_dof(int node, const Visit& visit) const;  // tied_codes.hpp

  int n_nodes_ = 0, n_i_ = 0, n_b_ = 0;
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> points_;
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

 private:
  void number_dofs(const Part& part);
  void mark_rotations(const Part& part);
  void follow(const Part& part);
};

}  // namespace flexura::reduce
