// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/solver/integrators/integrator.hpp"

/// Looks, while a run goes on, whether another integrator would go faster from where it stands: after 1000
/// steps (250 of large matrices), 4000, 16000, ... of one method the others take steps of their own from a copy of the state, for a
/// few per cent of the work done so far.  What is compared is simulated time for each unit of work.  Work is
/// counted (evaluations and matrices, weighed by their operations), never timed: a run repeated looks at the
/// same places and sees the same.
namespace flexura::mbs {

class MethodWatch {
 public:
  MethodWatch(const Equations& eq, const SolverOptions& options);

  /// The integrator `method` ended a step at t, having counted so much since it was made.  True where it is
  /// time to look.
  bool step(const std::string& method, double t, const StepCounts& counts);

  /// Looks from the consistent state s with accelerations v_dot (n_v), no further than `until` [s], where the next known
  /// event is.  Returns the method to change to, or an empty word where `method` may go on, as it may wherever the user chose it.
  std::string look(const std::string& method, const State& s, const Eigen::VectorXd& v_dot, double until);

  /// The integrator started anew at t, behind an event.
  void restart(double t);
  /// Where events follow one another so soon (samples of a controller) that `method`, which begins at order one, never
  /// comes beyond: a method of full order in every step, else an empty word.
  std::string for_events(const std::string& method);
  double between_events() const { return between_events_; }  ///< on the average of the last ones [s]

  /// `method` failed at s: a method that comes on from there, or an empty word.
  std::string after_failure(const std::string& method, const State& s, const Eigen::VectorXd& v_dot);

  /// Another method goes on, its counts beginning at 0.
  void change();

  /// One sentence where another method would have needed much less work for the whole run, else empty.
  std::string hint(const std::string& method) const;

  /// Simulated time for a unit of work since half of the way to this look [s].
  double pace() const { return pace_; }
  double last_gain() const { return last_gain_; }  ///< of the method that look() returned

  void remember(History& history);
  /// The integrator goes on with these counts.
  void take_counts(const std::string& method, const StepCounts& counts) { counted_ = work(method, counts); }

 private:
  double work(const std::string& method, const StepCounts& counts) const;
  double pace_of(const std::string& method, const State& s, const Eigen::VectorXd& v_dot, double budget,
                 double until) const;

  const Equations& eq_;
  SolverOptions options_;
  double n_;  // order of the matrices
  long first_look_;
  long steps_ = 0, next_look_, half_way_;  // of this method
  double work_ = 0.0, counted_ = 0.0;      // of this method; what its counts said last
  double t_half_ = 0.0, work_half_ = 0.0, work_looked_ = 0.0;
  double pace_ = 0.0, last_gain_ = 0.0;
  std::vector<std::string> others_;
  std::vector<double> work_of_others_;  // for what was looked at so far
  double work_compared_ = 0.0;
  long restarts_ = 0, steps_at_first_ = 0;  // of the events that are being counted
  double t_first_ = 0.0, between_events_ = 0.0;
  bool is_ruled_by_events_ = false;
};

}  // namespace flexura::mbs
