// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>
#include <utility>
#include <vector>

#include "reduce/assembly/input/initial_strain.hpp"
#include "reduce/assembly/ties/tied_numbering.hpp"
#include "reduce/linalg/factor/row_exchange.hpp"

/// What each rank of a team has of a part: METIS cuts the mesh into as many pieces as there are ranks, and a rank knows the
/// cells of its piece, their nodes and the dofs that move these, K = sum of the ranks' K_r.  Vectors are shared by rows: a
/// dof's row belongs to the first rank that has an element at it.  Only rank 0 knows the whole part.
namespace flexura::reduce {

struct PartShare {
  const linalg::Team* team = nullptr;
  Part
      part;  ///< cells, materials, nodes of the cells, interfaces without nodes; rank 0's has masses, links, matrices
  TiedNumbering numbering;  ///< of the part's nodes
  linalg::RowShares rows;   ///< of numbering's interior dofs
  int n_i = 0;              ///< interior dofs of all ranks
  int n_nodes = 0;          ///< of the whole part
  std::vector<int> pins;    ///< TiedModel::pins(), by their numbers among the rows of all ranks
  std::vector<int> averaged_dofs;
  Eigen::MatrixXd At;  ///< this rank's rows of the averages' A^T
  /// Of each interface, where nothing holds the part: its node's six motions are J u_i; this rank's rows of J^T.
  std::vector<Eigen::SparseMatrix<double>> Jt;

  /// Of rank 0 alone: of each node of the whole part the rank that tells of it, and its number there; of each cell its rank.
  std::vector<std::pair<int, int>> place_of_node;
  std::vector<int> part_of;
};

/// What a rank makes of a field on all nodes (n x 3): the rows of the nodes that it has.  `once`: each node's row goes to one
/// rank only.
class NodeShares {
 public:
  NodeShares(const Part& part, const std::vector<int>& part_of, int n_ranks);

  const std::vector<mesh::Index>& nodes(int rank) const { return nodes_[static_cast<std::size_t>(rank)]; }
  const std::vector<std::pair<int, int>>& places() const { return places_; }
  Eigen::MatrixX3d rows(const Eigen::MatrixX3d& field, int rank, bool once) const;

 private:
  std::vector<std::vector<mesh::Index>> nodes_;
  std::vector<std::pair<int, int>> places_;
};

/// A whole part that is to be shared, on rank 0: checked, numbered and cut.
class SharedPart {
 public:
  /// Throws std::invalid_argument for parts that cannot be reduced (tied_model.hpp) or not by a team.
  SharedPart(const linalg::Team& team, const Part& part);
  /// Cut as `part_of` says, a rank for each cell.  `may_be_free`: interfaces need not hold it (AssemblyOptions).
  SharedPart(const linalg::Team& team, const Part& part, std::vector<int> part_of, bool may_be_free);
  ~SharedPart();

  const NodeShares& nodes() const;
  /// Of numbers for each solid, in the order of the blocks, those of a rank's, in the order of its own; nothing of nothing.
  CellStrains cell_rows(const CellStrains& all, int rank) const;
  /// Collective, with take_share() on the other ranks: hands out the shares, returns rank 0's.
  PartShare hand_out() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// On the ranks that do not lead.
PartShare take_share(const linalg::Team& team);

/// Collective: the share of a part with the mesh and the cut of `share` and other ties or retained directions, so that the
/// nodes here are the same and dofs that both have belong to the same ranks.  `part` is read on rank 0 alone; what SharedPart
/// throws there is thrown on all.
PartShare share_retied(const PartShare& share, const Part& part, bool may_be_free = false);

/// Collective: rows of U (3 for each node here) at nodes of the whole part, which rank 0 names and is given.
Eigen::MatrixXd collect_nodes(const PartShare& share, const Eigen::Ref<const Eigen::MatrixXd>& U,
                              const std::vector<mesh::Index>& nodes);

}  // namespace flexura::reduce
