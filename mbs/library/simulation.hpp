// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mbs/library/same_layout.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/solver/run/guided_run.hpp"
#include "mbs/solver/start/prepare.hpp"

namespace flexura::mbs {

struct SimulationOptions {
  Method method =
      Method::automatic;  ///< Radau IIA where bodies deform, IDA otherwise, and changed where steps collapse
  double tolerance = 1e-6;  ///< relative error allowed in a step
  double end_time = 10.0;   ///< [s]; advance() goes no further, and steps are at most a tenth of it
  double max_step = 0.0;    ///< [s]; 0: a tenth of end_time
  double fixed_step = 0.0;  ///< [s]; 0: variable; shorter where advance() ends
};

/// A mechanism in motion, led by a loop of the program's own:
///
///     Simulation s(m, {.method = Method::radau, .tolerance = 1e-6});
///     while (s.time() < 1.0) {
///       s.set_input("torque", law(s.output("main.angle")));
///       s.advance(0.01);
///     }
///
/// The integrator takes steps of its own, the last of which ends where advance() does: what the program changes between two
/// calls, by set_input() or in variables that its elements read, acts from that time on and not before.  The state is brought
/// onto the constraints to round-off, with its accelerations and multipliers.
class Simulation {
 public:
  /// Assembles the mechanism at t = 0 (`m` stays as it is).  Throws std::runtime_error where it cannot be assembled.
  explicit Simulation(const Mechanism& m, const SimulationOptions& options = {});

  /// That of a mechanism file: starts as its solver.initial_state says, and knows its sets of states.  Of [solver] nothing else is
  /// taken.
  explicit Simulation(const PreparedMechanism& file, const SimulationOptions& options = {});

  /// The sets of states that start_from() knows: "zero", then [state.NAME] of the file and those of add_state_set().
  std::vector<std::string> state_sets() const;
  /// Takes the place of a set of this name.  Throws std::invalid_argument for one called "zero".
  void add_state_set(const StateSet& set);
  /// Assembles the mechanism anew in this set of states, at the set's time or that of the first start, whatever it has done; what the
  /// set does not name is as the mechanism has it, inputs keep their values.  notes() are those of this start.  Throws
  /// input::InputError for an unknown set and for states that are not there, std::runtime_error where it cannot be assembled;
  /// then nothing has changed.
  void start_from(const std::string& set);

  double time() const { return started_.state.t; }
  const State& state() const { return started_.state; }
  const Eigen::VectorXd& accelerations() const { return started_.v_dot; }  ///< n_v
  /// What the user should know: of the start rows that were left out, values that had to move, ..., then changes of the method.
  const std::vector<std::string>& notes() const { return started_.notes; }
  /// Of the motion so far.
  const EnergyAccount& energy() const { return energy_; }
  const Mechanism& mechanism() const { return *started_.mechanism; }

  /// Goes on by `step` [s].  Throws std::runtime_error where the motion cannot go on: the state is then the last one that
  /// was reached.
  void advance(double step);

  /// The input `name` has this value [SI] from the present time on.  Before the first advance() the mechanism is assembled
  /// anew with it.  Throws std::invalid_argument for an input that is not there, follows a formula of t or gets no finite
  /// number.  A drive that follows it cannot jump: the next advance() then throws.
  void set_input(const std::string& name, double value);

  /// For what the program changed so that no acceleration, rate of a state or switch shows it yet (a damper at rest); all
  /// else is seen.  Without it the next steps take the change as a fast one.
  void begin_anew();

  /// A quantity of the present state by its name (Mechanism::quantities()) [SI].  Throws std::invalid_argument.
  double output(const std::string& name) const;

 private:
  void assemble(const Mechanism& m, const Eigen::VectorXd& u);

  StartedMechanism started_;
  std::vector<StateSet> sets_;
  std::vector<std::string> deformable_;
  std::unique_ptr<Equations::Scratch> scratch_;
  EnergyAccount energy_;
  std::unique_ptr<GuidedRun> run_;  ///< from the first advance() on
  // The last steps, all of one length, begin at from_: their ends are sums of no rounded sums.
  double from_ = 0.0, length_ = 0.0, n_ = 0.0;
  mutable std::map<std::string, int> places_;
};

}  // namespace flexura::mbs
