// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/history.hpp"
#include "mbs/solver/algebra/saddle.hpp"

/// How near the constraint rows of a run's states come to depending on each other, and what that makes of these states.
///
/// With sigma the rows' independence, positions that are right to e (in parts of the mechanism's size) let it stand e / sigma
/// away along the motion that the rows nearly allow. Speeds change by e / sigma^2 of themselves, accelerations by up to
/// e / sigma^3, reactions by up to e / sigma^4; how much it is depends on the linkage and on its loads. So it is tried:
/// the state is moved by what its rows are open by, and its speeds, accelerations and reactions are solved for there.
namespace flexura::mbs {

class RankWatch {
 public:
  struct Nearness {
    double largest = 0.0;  ///< of all independences, see SaddleSolver::independence()
    /// By what speeds, accelerations and reactions of rows that were judged may be off, in parts of themselves: the largest of
    /// rows near a loss of rank, where above 1 nothing is known, and of the others.
    double doubt = 0.0, doubt_elsewhere = 0.0;
    double doubt_between = 0.0;   ///< as open / sigma^2, of states that the energy account alone sees
    double t = 0.0, sigma = 1.0;  ///< time and independence where `doubt` is
    Eigen::VectorXd p;            ///< there
  };

  explicit RankWatch(const Equations& eq);

  /// Of factors made for a state of the run.
  void note(const SaddleSolver& saddle);
  /// Of a state, by factors of its own: loops close better by those from before a dead point. NaN where there are none (no mass
  /// matrix).
  double independence(const State& s);
  double independence(const SaddleSolver& saddle) const;
  /// Rows that are near to dependent wherever the mechanism stands (a heavy body on a light one) are judged too.
  bool is_near(double independence) const;
  /// Accelerations of a state on its constraints are right to seven digits and fewer there.
  bool is_lost(double independence) const { return independence < 1e-3 * nearness_.largest; }
  bool is_beside(double independence) const { return independence < 0.01 * nearness_.largest; }

  /// A state to show, its loops closed as well as they are.
  void judge(const State& s, const Eigen::VectorXd& v_dot);
  /// One that the energy account alone sees, open by so much (in parts of the mechanism's size).
  void judge_between(double independence, double open);

  const Nearness& nearness() const { return nearness_; }
  void forget_rows() { longest_.setZero(); }
  void remember(History& history);

 private:
  double change_by_what_is_open(const State& s, const Eigen::VectorXd& v_dot);
  double change(const State& s, const Eigen::VectorXd& v_dot, const Eigen::VectorXd& move,
                const Eigen::VectorXd& speed);
  void widest(Eigen::VectorXd& open);

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  AccelerationSolver accelerations_;
  SaddleSolver saddle_, moved_;
  Nearness nearness_;
  ConstraintSizes sizes_;  // at the state that is tried
  State trial_;
  Eigen::MatrixXd M_, G_;
  Eigen::VectorXd g_, g_dot_, rest_, d_, x_, v_dot_, scale_,
      longest_;  // of each row so far, in units of the coordinates' inertia
};

}  // namespace flexura::mbs
