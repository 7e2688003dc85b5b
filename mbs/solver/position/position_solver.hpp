// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>

#include "mbs/equations/equations.hpp"

namespace flexura::mbs {

/// What steps are measured by: rows by their gradients, so that all are worth the same to Newton's method, or by the
/// sizes of the parts alone, where what is left open is to be small.
enum class Measure { gradients, gaps };

/// One solution of g(p) = 0 by damped minimum-norm steps from a start.
class PositionSolver {
 public:
  /// `large` (n_v) is what steps are parts of; a state in `when` outlives it.
  PositionSolver(const Equations& eq, When when, Eigen::VectorXd free, Eigen::VectorXd large,
                 Measure measure = Measure::gradients)
      : eq_(eq),
        n_(eq.sizes()),
        when_(when),
        measure_(measure),
        scratch_(eq.make_scratch()),
        free_(std::move(free)),
        step_scale_(std::move(large)) {
    M_.setZero(n_.n_v, n_.n_v);
    G_.setZero(n_.n_lambda, n_.n_v);
    g_.setZero(n_.n_lambda);
  }

  bool solve(Eigen::VectorXd& p, int max_iterations);
  /// To where the gaps are least, by the steps of K. Levenberg and D. W. Marquardt.
  void approach(Eigen::VectorXd& p, int max_iterations);

  const Eigen::VectorXd& residual() const { return g_; }
  const Eigen::VectorXd& allowed() const { return allowed_; }
  const ConstraintSizes& sizes() const { return sizes_; }
  /// Open by no more than a millionth of the mechanism's size: finer than parts are made, and no more than a
  /// change of the loop's lengths in the seventh digit would mend.
  bool nearly_closed() const { return (g_.cwiseAbs().array() <= 1e3 * allowed_.array()).all(); }
  /// Open by round-off alone, if by that.
  bool is_closed() const {
    return (g_.cwiseAbs().array() <= (1e-12 * sizes_.size).cwiseMax(10.0 * sizes_.round_off).array()).all();
  }
  /// How far open, in units of what is allowed.
  double openness() const { return g_.size() > 0 ? (g_.array() / allowed_.array()).abs().maxCoeff() : 0.0; }
  /// All that is open is so by rows that nothing can change: their names, else "".
  std::string rows_out_of_reach() const;
  int iterations() const { return iterations_; }
  double change() const { return change_; }

 private:
  void linearise(const Eigen::VectorXd& p);
  bool is_round_off() const { return (g_.cwiseAbs().array() <= sizes_.round_off.array()).all(); }
  double merit(const Eigen::VectorXd& g) const { return row_scale_.cwiseProduct(g).norm(); }

  const Equations& eq_;
  Sizes n_;
  When when_;
  Measure measure_;
  std::unique_ptr<Equations::Scratch> scratch_;
  Eigen::MatrixXd M_, G_, H_;
  Eigen::VectorXd free_, step_scale_, g_, column_scale_, row_scale_, allowed_;
  ConstraintSizes sizes_;
  int iterations_ = 0;
  double change_ = 0.0;
};

}  // namespace flexura::mbs
