// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "reduce/assembly/part.hpp"
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

/// Which nodes have six dofs: those of shells, and of frame elements that resist their rotation.
std::vector<char> nodes_with_rotations(const Part& part);

class TiedModel {
 public:
  /// Numbers the dofs and assembles.  Throws std::invalid_argument, naming what and how many, for: no
  /// interface, interfaces that share nodes or are too narrow, interfaces that leave a rigid motion free,
  /// pieces that hang on nothing, inverted elements, materials that are missing.
  explicit TiedModel(const Part& part, const AssemblyOptions& options = {});

  int n_nodes() const { return n_nodes_; }
  int n_i() const { return n_i_; }
  int n_b() const { return n_b_; }
  int n_interfaces() const { return static_cast<int>(interfaces_.size()); }

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

  /// Interior dofs by nodes: ascending, first 0, last n_i.
  const std::vector<int>& group_begin() const { return group_begin_; }

  /// U = C_i u_i + C_b u_b: 3 n_nodes x k, row 3 node + direction.
  void expand(const Eigen::Ref<const Eigen::MatrixXd>& u_i, const Eigen::Ref<const Eigen::MatrixXd>& u_b,
              Eigen::MatrixXd& U) const;
  /// f_i = C_i^T F, f_b = C_b^T F.
  void gather(const Eigen::Ref<const Eigen::MatrixXd>& F, Eigen::MatrixXd& f_i, Eigen::MatrixXd& f_b) const;
  /// K_ii + shift M_ii, on the pattern of K_ii.
  linalg::SymmetricMatrix shifted_stiffness(double shift) const;
  /// Y = M_ii X.
  void multiply_M_ii(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const;

  /// The directions in which a link acts: n n^T, or 1 where its ends coincide.
  Eigen::Matrix3d direction_projector(const Link& link) const;

  /// u_i of displacements U of all nodes (3 n_nodes x k), rotations as expand_rotations gives them, and motions of
  /// the interface nodes (6 x k each).
  Eigen::MatrixXd interior_part(const Eigen::Ref<const Eigen::MatrixXd>& U,
                                const Eigen::Ref<const Eigen::MatrixXd>& rotations,
                                const std::vector<Eigen::MatrixXd>& interface_motions) const;

  /// The rotations of the nodes that have them (shells, beams): 3 n_rotations() x k, row 3 rotation_of(node) + axis.
  Eigen::MatrixXd expand_rotations(const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                                   const Eigen::Ref<const Eigen::MatrixXd>& u_b) const;
  int n_rotations() const { return static_cast<int>(rotation_code_.size()); }
  int rotation_of(mesh::Index node) const { return rotation_of_[node]; }  ///< -1: it has none

  /// Where each interior dof is in another model of the same part with other ties: its number there, or -1.
  std::vector<int> interior_in(const TiedModel& other) const;

  /// The six rigid motions (about Bo) of the boundary dofs, n_b x 6, of the interior ones, n_i x 6, of all nodes,
  /// 3 n_nodes x 6, and of the rotations, 3 n_rotations x 6.
  Eigen::MatrixXd rigid_b() const;
  Eigen::MatrixXd rigid_i() const;
  Eigen::MatrixXd rigid_nodes() const;
  Eigen::MatrixXd rigid_rotations() const;

  /// First boundary dof of an interface; its retained directions follow.
  int first_dof(int interface) const { return interfaces_[interface].first_b; }
  const std::vector<int>& directions(int interface) const { return interfaces_[interface].directions; }
  const Eigen::Vector3d& point(int interface) const { return interfaces_[interface].point; }
  /// The six motions (u, theta) of an interface node: 6 x k, of displacements u_i (n_i x k) and u_b (n_b x
  /// k).
  Eigen::MatrixXd interface_motion(int interface, const Eigen::Ref<const Eigen::MatrixXd>& u_i,
                                   const Eigen::Ref<const Eigen::MatrixXd>& u_b) const;
  /// Loads (force, moment; 6 x k) on an interface node as loads on u_i, for directions that are not retained.
  Eigen::MatrixXd interface_load(int interface, const Eigen::Ref<const Eigen::MatrixXd>& load) const;

  /// Node of the mesh and direction of an interior dof: "node 12 in y" for messages.
  std::string describe_dof(int i) const;

 private:
  /// U = C u by rows: read(code, row) sets a row (of all columns) to the dof with this code, if it is one.
  template <class Read, class Rows>
  void spread(const Read& read, Rows& U) const;
  /// C^T F by rows: add(code, row) is called for every share of a dof.
  template <class Rows, class Add>
  void collect(const Rows& F, const Add& add) const;

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

  int code_of(const InterfaceDofs& interface, int direction) const;
  void check_interfaces(const Part& part, bool may_be_free) const;
  void check_pieces(const Part& part) const;
  void number_dofs(const Part& part);
  void mark_rotations(const Part& part);
  void follow(const Part& part);
  void add_groups(int node, std::vector<int>& groups) const;
  /// Calls visit(code, u) for every dof that moves a node: the dof, and the displacement for a unit of it.
  template <class Visit>
  void each_dof(int node, const Visit& visit) const;  // tied_codes.hpp
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
  std::unique_ptr<linalg::SymmetricMatrix> K_ii_, m_;
  Eigen::SparseMatrix<double> K_ib_;
  Eigen::MatrixXd K_bb_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> A_;
  std::vector<int> averaged_dofs_;
  std::vector<int> pins_;
  Shares shares_;
};

}  // namespace flexura::reduce
