// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
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
  /// Of what this rank of a team has of a part, which must outlive it.  Collective, as are all functions marked so, within
  /// Team::in_step().
  explicit TiedModel(const PartShare& share, const AssemblyOptions& options = {});
  TiedModel(const TiedModel&) = delete;
  TiedModel& operator=(const TiedModel&) = delete;

  const TiedNumbering& numbering() const { return numbering_; }
  int n_nodes() const { return numbering_.n_nodes(); }  ///< here
  int n_i() const { return n_i_; }                      ///< of all ranks
  int n_b() const { return numbering_.n_b(); }
  int n_interfaces() const { return numbering_.n_interfaces(); }
  /// C and its transpose.
  const TiedMotions& motions() const { return motions_; }

  const TiedMatrices& matrices() const { return matrices_; }
  const linalg::SymmetricMatrix& K_ii() const { return matrices_.K_ii(); }
  const Eigen::SparseMatrix<double>& K_ib() const { return matrices_.K_ib(); }  ///< n_i x n_b
  const Eigen::MatrixXd& K_bb() const { return K_bb_; }
  const linalg::SymmetricMatrix& m() const { return matrices_.m(); }  ///< n_nodes x n_nodes [kg]
  /// n_a x n_rows: averages of u_i; row r equals boundary dof averaged_dofs()[r].
  const Eigen::SparseMatrix<double, Eigen::RowMajor>& A() const { return averages_.A(); }
  const std::vector<int>& averaged_dofs() const { return averages_.dofs(); }
  /// Interior dofs at which weak springs would hold what the ties with stiffness of their own do not (0 to 6
  /// of them): the rows here, kElsewhere where another rank has them.
  const std::vector<int>& pins() const { return pins_; }
  static constexpr int kElsewhere = -1;
  Eigen::VectorXd pin_stiffness() const;  ///< diagonal entries of K_ii there; collective

  // Vectors of the interior (u_i) by the rows that this process has: all of them, or those that this rank of a team owns.
  int n_rows() const { return n_rows_; }
  const PartShare* share() const { return share_; }  ///< of a team; null where this process works alone
  bool leads() const { return !share_ || share_->team->rank() == 0; }

  // Collective.
  void multiply_K(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const;
  void multiply_magnitudes(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const;
  void multiply_M(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const;
  Eigen::MatrixXd dense_K_ib() const;  ///< n_rows x n_b
  /// C and its transpose for the nodes here; F: what the elements here contribute to forces on them.
  void expand(const Eigen::Ref<const Eigen::MatrixXd>& u_i, const Eigen::Ref<const Eigen::MatrixXd>& u_b,
              Eigen::MatrixXd& U) const;
  void gather(const Eigen::Ref<const Eigen::MatrixXd>& F, Eigen::MatrixXd& f_i, Eigen::MatrixXd& f_b) const;
  /// The six motions (u, theta; 6 x k) of an interface node, in a model that retains nothing of it.
  Eigen::MatrixXd interface_motion(int interface, const Eigen::Ref<const Eigen::MatrixXd>& u_i) const;
  /// Over all ranks: sums of numbers, A^T B, the Frobenius norm.
  Eigen::MatrixXd sum(Eigen::MatrixXd terms) const;
  Eigen::MatrixXd inner(const Eigen::Ref<const Eigen::MatrixXd>& A,
                        const Eigen::Ref<const Eigen::MatrixXd>& B) const;
  double norm(const Eigen::MatrixXd& A) const;
  /// Rank 0's, for all.
  void share(Eigen::MatrixXd& small) const;
  bool decide(bool here) const;
  /// Rows of U (3 n_nodes x k) at nodes of the whole part, which rank 0 names and is given; others get nothing.
  Eigen::MatrixXd at_nodes(const Eigen::Ref<const Eigen::MatrixXd>& U,
                           const std::vector<mesh::Index>& nodes) const;

  /// Of what numbering() says of its interior dofs the rows that are owned here.
  Eigen::MatrixXd own_rows(Eigen::MatrixXd interior) const;
  /// Where each row here is among those of another model of the same part with other ties, which this rank owns as well
  /// (share_retied()).
  std::vector<int> rows_in(const TiedModel& other) const;

 private:
  template <class Product>
  void shared(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y, const Product& product) const;

  TiedNumbering numbering_;
  std::vector<int> pins_;
  TiedAverages averages_;
  TiedMotions motions_;
  TiedMatrices matrices_;
  const PartShare* share_ = nullptr;
  std::unique_ptr<linalg::RowExchange> exchange_;
  int n_i_ = 0, n_rows_ = 0;
  Eigen::MatrixXd K_bb_;
};

}  // namespace flexura::reduce
