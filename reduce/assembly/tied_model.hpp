// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "reduce/assembly/input/part.hpp"
#include "reduce/assembly/tied_motions.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/factor/distributed_factor.hpp"

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

struct AssemblyOptions {
  /// Adds shift times the mass matrix to K everywhere (for eigensolves of bodies that are not held) [1/s^2].
  double shift = 0.0;
  /// Accepts interfaces that do not hold the body (with a shift, or to be clamped otherwise).
  bool may_be_free = false;
  /// Whose ranks compute the elements together, each its part of the mesh; null: this process alone.
  const linalg::Team* team = nullptr;
  linalg::Progress progress;
};

class TiedModel : public TiedMotions {
 public:
  /// Numbers the dofs and assembles.  Throws std::invalid_argument, naming what and how many, for: no
  /// interface, interfaces that share nodes or are too narrow, interfaces that leave a rigid motion free,
  /// pieces that hang on nothing, inverted elements, materials that are missing.
  explicit TiedModel(const Part& part, const AssemblyOptions& options = {});

  const linalg::SymmetricMatrix& K_ii() const { return *K_ii_; }
  const Eigen::SparseMatrix<double>& K_ib() const { return K_ib_; }  ///< n_i x n_b
  const Eigen::MatrixXd& K_bb() const { return K_bb_; }
  const linalg::SymmetricMatrix& m() const { return *m_; }  ///< n_nodes x n_nodes [kg]
  /// n_a x n_i: averages of u_i; row r equals boundary dof averaged_dofs()[r].
  const Eigen::SparseMatrix<double, Eigen::RowMajor>& A() const { return A_; }
  const std::vector<int>& averaged_dofs() const { return averaged_dofs_; }
  /// Interior dofs at which weak springs would hold what the ties with stiffness of their own do not (0 to 6
  /// of them).
  const std::vector<int>& pins() const { return pins_; }
  /// What the ranks of a team have computed of the model, and what this rank has of it (shared_assembly.cpp).
  struct Shares {
    const linalg::Team* team = nullptr;
    linalg::RowShares rows;
    std::unique_ptr<TiedModel> own;
  };
  const Shares& shares() const {
    return shares_;
  }  ///< without a team where the model is this process's alone
  /// On the ranks that do not lead: takes a share of a model's elements, computes it and sends the matrices
  /// to rank 0; null where its elements are bad, which rank 0 then says.
  static std::unique_ptr<TiedModel> take_share(const linalg::Team& team, linalg::RowShares& rows);

  /// K_ii + shift M_ii, on the pattern of K_ii.
  linalg::SymmetricMatrix shifted_stiffness(double shift) const;
  /// Y = M_ii X.
  void multiply_M_ii(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const;

  /// The directions in which a link acts: n n^T, or 1 where its ends coincide.
  Eigen::Matrix3d direction_projector(const Link& link) const;

 private:
  void check_interfaces(const Part& part, bool may_be_free) const;
  void check_pieces(const Part& part) const;
  void choose_pins();
  void build_patterns(const Part& part);
  void assemble(const Part& part, const AssemblyOptions& options);
  void average(const Part& part);

  TiedModel(linalg::Message& numbering, const Part& share, const AssemblyOptions& options);
  void put_numbering(linalg::Message& message) const;
  void put_matrices(linalg::Message& message) const;
  void add_matrices(linalg::Message& message);
  void assemble_together(const Part& part, const AssemblyOptions& options);
  linalg::RowShares share_rows(const Part& part, const std::vector<int>& part_of, int n_parts) const;

  std::unique_ptr<linalg::SymmetricMatrix> K_ii_, m_;
  Eigen::SparseMatrix<double> K_ib_;
  Eigen::MatrixXd K_bb_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> A_;
  std::vector<int> averaged_dofs_;
  std::vector<int> pins_;
  Shares shares_;
};

}  // namespace flexura::reduce
