// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/accuracy/error_weights.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/history.hpp"
#include "mbs/solver/algebra/saddle.hpp"
#include "mbs/solver/position/rank_watch.hpp"

/// Back onto the constraints by the smallest change in the norm of M, from nearby (the end of a step):
///     position   p <- retract(p, d),  M d + G^T x = 0,  G d = -g             simplified Newton
///     velocity   v <- v + d,          M d + G^T x = 0,  G d = -(G v + g_t)   with the same factorisation
namespace flexura::mbs {

class Projector {
 public:
  explicit Projector(const Equations& eq);

  /// False when g does not come down: s is then too far away.  Positions, then velocities.
  bool project(State& s);

 private:
  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  SaddleSolver saddle_;
  Eigen::MatrixXd M_, G_;
  Eigen::VectorXd g_, zero_, d_, x_, p_, scale_;
};

/// The same for every state that a run gives away, cheaply, and its accelerations and multipliers: implicit methods close their loops to Newton's
/// tolerance, which follows that of the run; behind this class stands round-off, 1e-11 of what a typical
/// motion changes in a row, whatever the tolerance.  The integrator keeps its own state, so that nothing of
/// this enters its history of rates.  One factorisation serves as long as it makes the residuals fall to a
/// tenth at a time.
class LoopCloser {
 public:
  /// The largest |g| and |G v + g_t|.
  struct Drift {
    double position = 0.0, velocity = 0.0;
  };

  LoopCloser(const Equations& eq, const SolverOptions& options);

  /// Positions and velocities of a row, which may lie inside a long step whose polynomial closes loops less
  /// well, of a switch or of the end of a run.  Leaves s as it was where Newton's method takes less than nine
  /// tenths of g away at once and positions would change by more than ten times the error allowed in a step:
  /// near a dead point, where the residual says little about the distance.  States near a loss of rank are closed to the last
  /// digit: what is left would grow by powers of 1 / sigma.  Returns what is left open.
  /// `is_shown`: as a row, not to an account alone; its rank is looked at then, and judge() follows.
  Drift close(State& s, bool is_shown = false);
  /// The same of s as it is.
  Drift drift(const State& s);
  /// After close(): accelerations and multipliers that belong to the state, by the same factorisation, in
  /// place of those of the integrator's polynomial, from which it starts.  An integrator's rates are two
  /// orders less accurate than its positions.  Where the loops did not close they are those of the state as it
  /// stands.  Leaves them as they are where the equations cannot be solved: the integrator will say so.
  void accelerate(State& s, Eigen::VectorXd& v_dot);
  /// Of the last close(): rows nearly lose rank there, so that the nearest closed state may be far.
  bool is_beside_dead_point() const { return is_beside_dead_point_; }
  /// After accelerate(), of a row: what it is worth where rows come near to depending on each other.
  void judge(const State& s, const Eigen::VectorXd& v_dot) { ranks_.judge(s, v_dot); }
  /// Of all states given to close() and judge() so far.
  const RankWatch::Nearness& nearness() const { return ranks_.nearness(); }
  /// Of rows that are others now.
  void forget_factors() {
    has_factors_ = false;
    ranks_.forget_rows();
  }
  /// Where the factorisation was made, so that a continued run repeats the unbroken one to the bit.
  void remember(History& history);

 private:
  struct Residuals {
    double position = 0.0, velocity = 0.0;
    double larger() const { return std::max(position, velocity); }
    bool closed() const { return larger() <= 1.0; }
  };
  void factor(const State& s);
  void look_at_rank(State& s, bool is_shown);
  void close_to_the_last_digit(State& s);
  Residuals residuals(const State& s);
  void correct_position(State& s);
  void correct_velocity(State& s);
  bool close_trial(const State& s, bool& is_near);

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  ErrorWeights weights_;
  SaddleSolver saddle_;
  RankWatch ranks_;
  AccelerationSolver accelerations_;
  double
      enough_;  // what accelerations may lack, relative: 1e-4 of the tolerance, between round-off and 1e-10
  bool has_factors_ = false, is_closed_ = true, is_near_ = false,
       is_beside_dead_point_ = false;  // the latter three of the last close()
  State at_factors_;                   // t, p and c
  Drift drift_;                        // at the last residuals()
  State trial_;
  Eigen::MatrixXd M_, G_;
  Eigen::VectorXd g_, g_dot_, round_off_, rest_, d_, x_, p_, scale_, w_, change_, v_dot_0_;
};

}  // namespace flexura::mbs
