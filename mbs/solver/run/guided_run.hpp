// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "mbs/solver/run/energy.hpp"

/// A run that goes where its caller says, step by step, while the caller changes what acts: inputs, and what forces of the
/// caller's own read.  Its steps end where they are told to, so that nothing behind that time is known yet; what is changed
/// there acts from there on.  Of a change that accelerations, rates of states or switches show at that instant, the
/// integrator knows beforehand and starts anew; any other (a damper at rest) its error control meets in the next step.
namespace flexura::mbs {

class Runner;

class GuidedRun {
 public:
  /// From the consistent state `start` with its inputs (State::u) and accelerations v_dot (n_v) on.
  GuidedRun(const Equations& eq, const State& start, const Eigen::VectorXd& v_dot,
            const SolverOptions& options);
  ~GuidedRun();

  /// Goes to t [s], at most options.end_time; false where the motion cannot go on (stopped_because()): the state is then
  /// the last one that was reached.
  bool go_to(double t);
  /// From the present time on `u` (n_inputs) is added to the inputs.
  void set_inputs(const Eigen::VectorXd& u);
  /// Something acts in another way from the present time on.
  void begin_anew();

  /// On the constraints to round-off, with the multipliers of the state.
  const State& state() const { return now_.state; }
  const Eigen::VectorXd& accelerations() const { return now_.v_dot; }
  const EnergyAccount& energy() const { return energy_; }
  const std::string& stopped_because() const;
  /// One sentence for each, where the method was left open.
  const std::vector<std::string>& method_changes() const;

 private:
  std::unique_ptr<Runner> runner_;
  Instant now_;
  EnergyAccount energy_;
};

}  // namespace flexura::mbs
