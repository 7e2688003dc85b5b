// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/linalg/petsc/team.hpp"

/// Blocks of vectors whose rows a team shares.  Every function is collective, within Team::together().
namespace flexura::linalg {

/// Who owns which rows of a matrix that a team shares.
struct RowShares {
  std::vector<int>
      number;  ///< of each row that is known here: where it is among those of all ranks, rank 0's first
  std::vector<int> begin;                 ///< size + 1: rank r owns numbers begin[r] ... begin[r + 1] - 1
  int n() const { return begin.back(); }  ///< rows of all ranks
  int n_own(const Team& team) const { return begin[team.rank() + 1] - begin[team.rank()]; }
};

/// Each rank gets its rows of what rank 0 gives (n x k), where it knows all rows; others give nothing.
Eigen::MatrixXd scatter_rows(const Team& team, const RowShares& rows,
                             const Eigen::Ref<const Eigen::MatrixXd>& all);

/// For products with a matrix A = sum of A_r, of which rank r holds A_r: vectors by the rows that A_r meets, and by those
/// that the rank owns.
class RowExchange {
 public:
  /// The rows known here are those that this rank's part meets.
  RowExchange(const Team& team, const RowShares& rows);

  /// From the rows that each rank owns to those that this rank's part meets.
  Eigen::MatrixXd spread(const Eigen::Ref<const Eigen::MatrixXd>& own) const;
  /// The sum of what all ranks' parts give, the rows that this rank owns.
  Eigen::MatrixXd collect(const Eigen::Ref<const Eigen::MatrixXd>& parts) const;
  /// Of the rows that this rank's part meets those that it owns.
  Eigen::MatrixXd own_of(const Eigen::Ref<const Eigen::MatrixXd>& parts) const;

 private:
  int n_own_ = 0, n_ = 0, rank_ = 0;
  // By ranks: rows met here that are asked of them, and places among the own rows that they ask for.
  std::vector<std::vector<int>> asked_, given_;
};

}  // namespace flexura::linalg
