// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <utility>
#include <vector>

#include "reduce/assembly/ties/tied_numbering.hpp"

namespace flexura::reduce {

/// The averaging ties: A u_i = u_b of the averaged rows (tied_model.hpp).
class TiedAverages {
 public:
  using Map = Eigen::Matrix<double, 6, Eigen::Dynamic>;

  /// Throws std::invalid_argument where the mean is of nodes that another interface binds.
  TiedAverages(const Part& part, const TiedNumbering& numbering);
  /// Those of a share of a part: the columns of A that belong to its rows, and dofs().
  TiedAverages(const Eigen::SparseMatrix<double, Eigen::RowMajor>& A, std::vector<int> dofs)
      : A_(A), dofs_(std::move(dofs)) {}

  /// n_a x n_i: averages of u_i; row r equals boundary dof dofs()[r].
  const Eigen::SparseMatrix<double, Eigen::RowMajor>& A() const { return A_; }
  const std::vector<int>& dofs() const { return dofs_; }
  /// u, theta of an interface's set of its nodes' displacements (6 x 3 nodes); empty where its tie is no average.
  const Map& of(int interface) const { return maps_[interface]; }

 private:
  Eigen::SparseMatrix<double, Eigen::RowMajor> A_;
  std::vector<int> dofs_;
  std::vector<Map> maps_;
};

}  // namespace flexura::reduce
