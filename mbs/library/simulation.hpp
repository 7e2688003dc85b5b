// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/start.hpp"

namespace flexura::mbs {

struct SimulationOptions {
  Method method =
      Method::automatic;  ///< Radau IIA where bodies deform, IDA otherwise, and changed where steps collapse
  double tolerance = 1e-6;  ///< relative error allowed in a step
  double end_time = 10.0;   ///< [s]; advance() goes no further, and steps are at most a tenth of it
  double max_step = 0.0;    ///< [s]; 0: a tenth of end_time
  double fixed_step = 0.0;  ///< [s]; 0: variable
};

/// A mechanism in motion, row by row:
///
///     Simulation s(m, {.method = Method::radau, .tolerance = 1e-6});
///     while (s.time() < 1.0) {
///       s.advance(0.01);
///       use(s.state(), s.output("main.torque"));
///     }
///
/// The integrator takes steps of its own; rows are brought onto the constraints to round-off, with the accelerations
/// and multipliers of their state.
class Simulation {
 public:
  /// Assembles the mechanism at t = 0 (`m` stays as it is).  Throws std::runtime_error where it cannot be assembled.
  explicit Simulation(const Mechanism& m, const SimulationOptions& options = {});

  double time() const { return started_.state.t; }
  const State& state() const { return started_.state; }
  const Eigen::VectorXd& accelerations() const { return started_.v_dot; }  ///< n_v
  /// What the user should know of the start: rows that were left out, values that had to move, ...
  const std::vector<std::string>& notes() const { return started_.notes; }
  /// Of every row so far.
  const EnergyAccount& energy() const { return energy_; }
  const Mechanism& mechanism() const { return *started_.mechanism; }

  /// Goes on by `step` [s], the same at each call or a multiple of the first.  Throws std::runtime_error where the
  /// motion cannot go on: the state is then the last one that was reached.
  void advance(double step);

  /// A quantity of the present state by its name (Mechanism::quantities()) [SI].  Throws std::invalid_argument.
  double output(const std::string& name) const;

 private:
  struct Row {
    State state;
    Eigen::VectorXd v_dot;
    EnergyAccount energy;
  };
  void run_until(double t);

  StartedMechanism started_;
  std::unique_ptr<Equations::Scratch> scratch_;
  std::optional<Continuation> continuation_;
  std::deque<Row> ahead_;
  EnergyAccount energy_;
  bool is_over_ = false;       ///< the run has come to its end
  std::string ended_because_;  ///< before end_time; empty otherwise
  mutable std::map<std::string, int> places_;
};

}  // namespace flexura::mbs
