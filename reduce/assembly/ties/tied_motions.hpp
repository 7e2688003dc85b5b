// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "reduce/assembly/ties/tied_averages.hpp"

namespace flexura::reduce {

/// Motions of all nodes and interfaces from those of the dofs, and loads on the dofs from those on nodes: C of tied_model.hpp and
/// its transpose.
class TiedMotions {
 public:
  /// Both must outlive it.
  TiedMotions(const TiedNumbering& numbering, const TiedAverages& averages)
      : numbering_(numbering), averages_(averages) {}

  /// U = C_i u_i + C_b u_b: 3 n_nodes x k, row 3 node + direction.
  void expand(const Eigen::Ref<const Eigen::MatrixXd>& u_i, const Eigen::Ref<const Eigen::MatrixXd>& u_b,
              Eigen::MatrixXd& U) const;
  /// f_i = C_i^T F, f_b = C_b^T F.
  void gather(const Eigen::Ref<const Eigen::MatrixXd>& F, Eigen::MatrixXd& f_i, Eigen::MatrixXd& f_b) const;

  /// u_i of displacements U of all nodes (3 n_nodes x k), rotations as expand_rotations gives them, and motions of
  /// the interface nodes (6 x k each).
  Eigen::MatrixXd interior_part(const Eigen::Ref<const Eigen::MatrixXd>& U,
                                const Eigen::Ref<const Eigen::MatrixXd>& rotations,
                                const std::vector<Eigen::MatrixXd>& interface_motions) const;

  /// The rotations of the nodes that have them (shells, beams): 3 n_rotations() x k, row 3 rotation_of(node) + axis.
  Eigen::MatrixXd expand_rotations(const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                                   const Eigen::Ref<const Eigen::MatrixXd>& u_b) const;
  /// Where each interior dof is in another model of the same part with other ties: its number there, or -1.
  std::vector<int> interior_in(const TiedMotions& other) const;

  /// The six rigid motions (about Bo) of the boundary dofs, n_b x 6, of the interior ones, n_i x 6, of all nodes,
  /// 3 n_nodes x 6, and of the rotations, 3 n_rotations x 6.
  Eigen::MatrixXd rigid_b() const;
  Eigen::MatrixXd rigid_i() const;
  Eigen::MatrixXd rigid_nodes() const;
  Eigen::MatrixXd rigid_rotations() const;

  /// The six motions (u, theta) of an interface node: 6 x k, of displacements u_i (n_i x k) and u_b (n_b x
  /// k).
  Eigen::MatrixXd interface_motion(int interface, const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                                   const Eigen::Ref<const Eigen::MatrixXd>& u_b) const;
  /// Loads (force, moment; 6 x k) on an interface node as loads on u_i, for directions that are not retained.
  Eigen::MatrixXd interface_load(int interface, const Eigen::Ref<const Eigen::MatrixXd>& load) const;

  /// Node of the mesh and direction of an interior dof: "node 12 in y" for messages.
  std::string describe_dof(int i) const;

 private:
  const TiedNumbering& numbering_;
  const TiedAverages& averages_;
};

/// The six rigid motions (about Bo) of the boundary dofs, n_b x 6.
Eigen::MatrixXd rigid_boundary(const TiedNumbering& numbering);

}  // namespace flexura::reduce
