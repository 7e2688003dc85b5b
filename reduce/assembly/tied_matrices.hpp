// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <memory>

#include "reduce/assembly/ties/tied_numbering.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/dense/symmetric_matrix.hpp"

namespace flexura::reduce {

struct AssemblyOptions {
  /// Adds shift times the mass matrix to K everywhere (for eigensolves of bodies that are not held) [1/s^2].
  double shift = 0.0;
  /// Accepts interfaces that do not hold the body (with a shift, or to be clamped otherwise).
  bool may_be_free = false;
  linalg::Progress progress;
};

/// K and m of a part by the dofs of its numbering (the equations of tied_model.hpp), or of the share of it that a rank has.
class TiedMatrices {
 public:
  /// Which entries there are; none has a value yet.  The numbering must outlive it.
  TiedMatrices(const Part& part, const TiedNumbering& numbering);
  TiedMatrices(const TiedMatrices&) = delete;
  TiedMatrices& operator=(const TiedMatrices&) = delete;

  /// Computes all elements of the part.  Throws std::invalid_argument for inverted elements and materials that are missing.
  void assemble(const Part& part, const AssemblyOptions& options);

  const linalg::SymmetricMatrix& K_ii() const { return *K_ii_; }
  const Eigen::SparseMatrix<double>& K_ib() const { return K_ib_; }  ///< n_i x n_b
  const Eigen::MatrixXd& K_bb() const { return K_bb_; }
  const linalg::SymmetricMatrix& m() const { return *m_; }  ///< n_nodes x n_nodes [kg]

  /// K_ii + shift M_ii, on the pattern of K_ii.
  linalg::SymmetricMatrix shifted_stiffness(double shift) const;
  /// Y = M_ii X.
  void multiply_M_ii(const Eigen::Ref<const Eigen::MatrixXd>& X, Eigen::MatrixXd& Y) const;

 private:
  const TiedNumbering& numbering_;
  std::unique_ptr<linalg::SymmetricMatrix> K_ii_, m_;
  Eigen::SparseMatrix<double> K_ib_;
  Eigen::MatrixXd K_bb_;
};

/// The directions in which a link acts: n n^T, or 1 where its ends coincide.
Eigen::Matrix3d direction_projector(const TiedNumbering& numbering, const Link& link);

}  // namespace flexura::reduce
