// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/LU>

/// The linear equations of a small correction to a run,
///
///     M delta'' + D delta' + K delta + G^T dlambda = f(t),      G delta = 0,
///
/// with the matrices of the row, for several loads f (columns) at once.  One step of generalised-alpha (Chung
/// and Hulbert 1993, rho_inf = 0.4, in the form of Arnold and Bruels 2007: the equations hold at the rows
/// themselves, an auxiliary acceleration carries the algorithm) leads from row to row, whatever the
/// frequencies: what the rows do not resolve responds statically.
namespace flexura::study {

/// At one row: M, D, K n x n, G n_lambda x n.
struct LinearisedRow {
  Eigen::MatrixXd M, D, K, G;
  long number = 0;  ///< of its own where several rows share it, so that its factors serve for all; 0: none
};

class LinearCorrection {
 public:
  LinearCorrection(Eigen::Index n, Eigen::Index columns);

  /// To the next row, h [s] later; h = 0 at the first one, where it only finds the accelerations.  load n x
  /// columns; G in place of row.G, which may be that of an earlier row.
  void step(double h, const LinearisedRow& row, const Eigen::MatrixXd& G, const Eigen::MatrixXd& load);

  const Eigen::MatrixXd& delta() const { return delta_; }  ///< n x columns
  const Eigen::MatrixXd& rate() const { return rate_; }
  const Eigen::MatrixXd& acceleration() const { return acceleration_; }
  const Eigen::MatrixXd& dlambda() const { return dlambda_; }  ///< n_lambda x columns

 private:
  Eigen::MatrixXd delta_, rate_, acceleration_, auxiliary_, dlambda_;
  Eigen::PartialPivLU<Eigen::MatrixXd> A_;  // of the step solved last
  long number_ = 0;
  double h_ = 0.0;
};

}  // namespace flexura::study
