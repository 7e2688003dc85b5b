// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/assembly/shared_assembly.hpp"
#include "reduce/assembly/tied_matrices.hpp"
#include "reduce/assembly/ties/tied_motions.hpp"

/// The finite-element model of a part with its interface ties.
///
/// All nodal displacements U (3 n_nodes) follow from interior and boundary dofs,
///
///     U = C_i u_i + C_b u_b,       K_ii = C_i^T K C_i,  K_ib = C_i^T K C_b,  K_bb = C_b^T K C_b,
///
/// where C is the identity but for what follows others: nodes of rigid ties their interface node, Follower points the nodes of
/// shells and beams, dependent dofs of multipoint constraints those that they are combinations of.  These nodes have rotations as well, which are dofs beside
/// the displacements and no rows of U: what has mass or is looked at is a point.  Averaging
/// ties leave the mesh alone and say instead
///
///     A u_i = u_b (averaged rows).
///
/// Fixed interfaces mean u_b = 0, so u_i lies in the null space of A.  Nothing is eliminated for it and no
/// penalty is added: K_ii keeps the sparsity of the mesh, and TiedSolver borders it with A.  This is exact
/// and has no limit on the size of the averaged set.
///
/// The mass matrix is m (x) I_3 with the scalar nodal matrix m (n_nodes x n_nodes), kept on all nodes:
/// products with M_ii are C_i^T (m (x) I_3) C_i x.
namespace flexura::reduce {

class TiedModel {
 public:
  /// Numbers the dofs and assembles.  Throws std::invalid_argument, naming what and how many, for: no
  /// interface, interfaces that share nodes or are too narrow, interfaces that leave a rigid motion free,
  /// pieces that hang on nothing, inverted elements, materials that are missing.
  explicit TiedModel(const Part& part, const AssemblyOptions& options = {});
  TiedModel(const TiedModel&) = delete;
  TiedModel& operator=(const TiedModel&) = delete;

  const TiedNumbering& numbering() const { return numbering_; }
  int n_nodes() const { return numbering_.n_nodes(); }
  int n_i() const { return numbering_.n_i(); }
  int n_b() const { return numbering_.n_b(); }
  int n_interfaces() const { return numbering_.n_interfaces(); }
  /// C and its transpose.
  const TiedMotions& motions() const { return motions_; }

  const TiedMatrices& matrices() const { return matrices_; }
  const linalg::SymmetricMatrix& K_ii() const { return matrices_.K_ii(); }
  const Eigen::SparseMatrix<double>& K_ib() const { return matrices_.K_ib(); }  ///< n_i x n_b
  const Eigen::MatrixXd& K_bb() const { return matrices_.K_bb(); }
  const linalg::SymmetricMatrix& m() const { return matrices_.m(); }  ///< n_nodes x n_nodes [kg]
  /// n_a x n_i: averages of u_i; row r equals boundary dof averaged_dofs()[r].
  const Eigen::SparseMatrix<double, Eigen::RowMajor>& A() const { return averages_.A(); }
  const std::vector<int>& averaged_dofs() const { return averages_.dofs(); }
  /// Interior dofs at which weak springs would hold what the ties with stiffness of their own do not (0 to 6
  /// of them).
  const std::vector<int>& pins() const { return pins_; }
  const ModelShares& shares() const { return shares_; }

 private:
  TiedNumbering numbering_;
  std::vector<int> pins_;
  TiedAverages averages_;
  TiedMotions motions_;
  TiedMatrices matrices_;
  ModelShares shares_;
};

}  // namespace flexura::reduce
