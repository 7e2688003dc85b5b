// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/linalg/petsc/team.hpp"

/// Blocks of vectors whose rows a team shares.  Every function is collective, within Team::together().
namespace flexura::linalg {

/// Who owns which rows of a matrix that a team shares.
struct RowShares {
  std::vector<int> number;  ///< n: where a row is among the rows of all ranks, those of rank 0 first
  std::vector<int> begin;   ///< size + 1: rank r owns numbers begin[r] ... begin[r + 1] - 1
  int n_own(const Team& team) const { return begin[team.rank() + 1] - begin[team.rank()]; }
};

/// Each rank gets its rows of what rank 0 gives (n x k); others give nothing.
Eigen::MatrixXd scatter_rows(const Team& team, const RowShares& rows,
                             const Eigen::Ref<const Eigen::MatrixXd>& all);
/// Rank 0 gets all rows (n x k) of what each rank has; others get nothing.
Eigen::MatrixXd gather_rows(const Team& team, const RowShares& rows,
                            const Eigen::Ref<const Eigen::MatrixXd>& own);

/// For products with a matrix A = sum of A_r, of which rank r holds A_r: which rows of others A_r meets.
class RowExchange {
 public:
  /// `touched`: rows of 0 ... n - 1 that this rank's part meets.
  RowExchange(const Team& team, const RowShares& rows, const std::vector<int>& touched);

  /// From the rows that each rank owns to those that this rank's part meets: n x k, zeros elsewhere.
  Eigen::MatrixXd spread(const Eigen::Ref<const Eigen::MatrixXd>& own) const;
  /// The sum of what all ranks' parts give (n x k each), the rows that this rank owns.
  Eigen::MatrixXd collect(const Eigen::Ref<const Eigen::MatrixXd>& parts) const;

 private:
  int n_own_ = 0, n_ = 0;
  // By ranks: rows that this one asks of them (0 ... n - 1), and its own rows that they ask for.
  std::vector<std::vector<int>> asked_, given_;
};

}  // namespace flexura::linalg
