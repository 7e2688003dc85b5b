// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "reduce/beams/structure.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"
#include "reduce/linalg/factor/cholesky.hpp"

/// Boundary and interior dofs of a structure, its matrices split accordingly, and solves with K_ii.
namespace flexura::reduce {

/// An interface: a node of the beam model and the directions kept, 0-2 displacement, 3-5 rotation, ascending.
struct BeamInterface {
  std::string name;
  int node = -1;
  std::vector<int> directions = {0, 1, 2, 3, 4, 5};
};

struct Numbering {
  static constexpr int kUnused = std::numeric_limits<int>::min();
  std::vector<int> code;         ///< n_dofs: interior dof i, boundary -(b + 1), or kUnused
  std::vector<int> dof_of;       ///< n_i: interior dof -> dof of the structure
  std::vector<int> group_begin;  ///< of interior dofs, by nodes
  int n_i = 0, n_b = 0;

  /// Throws std::invalid_argument for interfaces that cannot be.
  Numbering(const Structure& structure, const std::vector<BeamInterface>& interfaces);
};

/// Interior block of a symmetric sparse matrix in the solver's form, and its interior-boundary block.
struct SplitMatrix {
  std::unique_ptr<linalg::SymmetricMatrix> ii;
  Eigen::MatrixXd ib;  ///< n_i x n_b

  SplitMatrix(const beam::SparseMatrix& A, const Numbering& numbering);
};

/// Throws std::invalid_argument, naming node and direction, where the interfaces do not hold the structure.
linalg::CholeskyFactor factorise(const Structure& structure, const Numbering& numbering,
                                 const SplitMatrix& K);

/// With one step of iterative refinement.
Eigen::MatrixXd solve_refined(const linalg::CholeskyFactor& factor, const linalg::SymmetricMatrix& K,
                              const Eigen::MatrixXd& B);

}  // namespace flexura::reduce
