// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>

#include "mbs/equations/equations.hpp"

/// Constraint rows that no multiplier holds, and whether they hold all the same.
///
/// A row is left out because near the assembled position it is a combination of kept ones, G_i = sum x_k G_k
/// (Mechanism::drop_redundant). It is met by itself only if that is so on all levels,
///
///     g_i = 0,    g_i' = G_i v + g_i,t = 0,    g_i'' = G_i v' + gamma_i = 0
///
/// which drives may contradict from the start (two motors on one degree of freedom), and only as long as it stays
/// so (a hinge out of line with the others lets nothing move).
namespace flexura::mbs {

class RowWatch {
 public:
  explicit RowWatch(const Equations& eq);

  /// Of a state whose kept rows hold on all levels, with its accelerations: throws AssemblyError naming rows
  /// that exclude each other. What they are open by there is what parts do not fit by; it counts from there.
  /// `at_dead_point`: the kept rows lose rank there, and rows left out are open because the speeds lie on no branch.
  void begin(const State& s, const Eigen::VectorXd& v_dot, bool at_dead_point = false);
  /// The same without judging it.
  void begin(const State& s);
  /// Goes on with other rows kept: what they are allowed stays.
  void change_rows(const State& s);

  /// How far the rows of a state are open in parts of what is allowed, a millionth of the mechanism's size
  /// (finer than parts are made, see assemble.cpp) beyond begin()'s, or of the speed with which it moves.
  struct Opening {
    double left_out = 0.0;                 ///< the worst of the rows left out; above 1 something contradicts
    double kept = 0.0;                     ///< of the others, positions alone
    double drift = 0.0, drift_rate = 0.0;  ///< largest |g| and |G v + g_t| of the rows left out
    int row = -1;                          ///< of left_out
    bool of_speed = false;                 ///< it is open by its rate
    double value = 0.0;                    ///< by this much
    int kept_row = -1;
    double kept_value = 0.0;
    /// Rows left out say something that the kept ones, open by `allowed` at most, do not: where these were not closed to the
    /// end, near a dead point, they open by as much.
    bool contradicts(double allowed) const { return left_out > (kept <= kClosed ? 1.0 : allowed); }
    static constexpr double kClosed = 1e-3;
  };
  /// Equilibria under moving drives are at rest: their rates say nothing.
  enum class Judge { positions, all };
  const Opening& look(const State& s, Judge judge = Judge::all);
  /// What the rows were open by at begin(), in parts of their size: how little the parts fit.
  double misfit() const { return misfit_; }
  bool watches() const { return n_ > 0; }
  /// What `kept` may be where Newton's method closed the loops to the run's tolerance and no better.
  static double allowed(double tolerance);

  /// Of the last look(), at its time t; `since` is when it began; `allowed` bounds the kept rows.
  std::string complaint(double t, double since, double allowed) const;
  std::string complaint_about_left_out(double t) const {
    return complaint(t, t, std::numeric_limits<double>::infinity());
  }

 private:
  void require_agreement(const State& s, const Eigen::VectorXd& v_dot, bool at_dead_point);

  const Equations& eq_;
  int n_, n_kept_;
  std::unique_ptr<Equations::Scratch> scratch_;
  ConstraintSizes sizes_, kept_sizes_;
  Eigen::VectorXd scale_, none_;
  Eigen::VectorXd g_, g_dot_, g_ddot_, g_kept_;
  double misfit_ = 0.0, open_ = 0.0;  // the latter: allowed of a row's size
  Opening opening_;
};

}  // namespace flexura::mbs
