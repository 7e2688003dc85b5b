// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/formulas/motion_function.hpp"
#include "mbs/formulas/time_function.hpp"
#include "mbs/mechanism/motion/tree_motion.hpp"

/// Signals that formulas read, and the dynamic states, algebraic states and switches that belong to single elements.
namespace flexura::mbs {

/// What ElementStates leaves of one state.
struct Signals {
  Eigen::VectorXd values;     ///< of all signals; those that nothing reads are not kept up
  std::vector<int> switches;  ///< positions of all of them
  Eigen::VectorXd algebraic;  ///< of controls, of measures, then contacts of constraints
  Eigen::VectorXd inputs;     ///< what is added to them, to their rates and to the rates of these (State::u)
};

class ElementStates {
 public:
  /// A condition of a formula whose position is held in a switch.
  struct Condition {
    std::shared_ptr<const Expression> formula;
    int node = 0, place = 0, number = 1;  ///< place: of the signal that holds it
  };
  struct SignalSource {
    enum class Kind { time, coordinate, speed, measure, control, input } kind = Kind::time;
    CoordinateRef coordinate;
    int element = -1;  ///< measure, control or input
  };

  explicit ElementStates(const Topology& tree);
  void size(int n_contacts, Signals& signals) const;

  int n_switches() const { return first_switch_.back() + static_cast<int>(conditions_.size()); }
  bool is_condition(int root) const { return root >= first_switch_.back(); }
  const std::vector<int>& algebraic() const { return algebraic_; }  ///< controls with an algebraic state
  /// Measures of accelerations and reactions that forces or controls read: their values are algebraic states, too.
  const std::vector<int>& coupled_measures() const { return coupled_measures_; }
  /// Among them; -1 for another measure.
  int coupled_measure(int measure) const;
  /// Algebraic states of controls and measures, the first of all.
  int n_algebraic() const { return static_cast<int>(algebraic_.size() + coupled_measures_.size()); }
  const std::vector<int>& used_signals() const {
    return used_signals_;
  }                                                                      ///< in the order of their evaluation
  const std::vector<SignalSource>& sources() const { return sources_; }  ///< of each signal
  int first_state_of_control(std::size_t i) const { return first_state_[i]; }
  int first_state_of_force(std::size_t i) const { return first_force_state_[i]; }
  const std::vector<std::shared_ptr<const TimeFunction>>& functions_of_time() const {
    return functions_of_time_;
  }
  const std::vector<std::shared_ptr<const MotionFunction>>& functions_of_motion() const {
    return functions_of_motion_;
  }
  /// Signals, then the arguments of forces' curves; after evaluate_signals().
  void arguments_of_motion(const Motion& motion, const Signals& signals, Eigen::VectorXd& x) const;

  /// c, switches, inputs and algebraic states of `s` into the scratch.
  void take_states(const State& s, Motion& motion, Signals& signals) const;
  /// Those that anything reads, after forward() on level velocity and take_states().
  void evaluate_signals(Motion& motion, Signals& signals) const;
  /// One of them, after those that it reads.
  void evaluate_signal(int place, const Motion& motion, Signals& signals) const;
  /// What a force has of its own, into kin.own.
  void own_states(std::size_t force, Motion& motion, const Signals& signals) const;
  double control_output(int control, const Motion& motion, const Signals& signals) const;
  double input_now(int input, const Motion& motion, const Signals& signals) const;
  /// b of the controls with an algebraic state, the first of b.
  void algebraic_equations(const Signals& signals, VectorRef b) const;

  // As in Equations, after evaluate_signals().
  void roots(Motion& motion, const Signals& signals, VectorRef values) const;
  void change_switch(int which, State& s, Motion& motion, const Signals& signals) const;
  /// `observe` gives the motion and the signals of s as it is when it is called.
  void start_switches(State& s, const std::function<std::pair<Motion&, const Signals&>()>& observe) const;
  /// Formulas as they are written; then, after evaluate_signals() of that, each condition held at what it is.
  void release_conditions(State& s) const;
  void hold_conditions(State& s, const Signals& signals) const;
  bool has_conditions() const { return !conditions_.empty(); }
  bool is_kink(int root) const;
  bool jumps_at(int root) const;
  std::string describe_root(int i) const;
  std::string name_of_root(int i) const;
  /// Of the states of controls and forces.
  std::string name_of_state(int i) const;
  bool is_held(int i) const;
  /// All switches off, states and algebraic states where their elements start them.
  void start(State& s, int n_contacts) const;

 private:
  void list_conditions(const std::vector<bool>& is_used);
  void list_curves();
  std::string name_of_force_state(int i) const;

  const Topology& tree_;
  std::vector<int> used_signals_;
  std::vector<int> first_state_;  ///< of each control in c, and their number at the end
  std::vector<int>
      first_force_state_;  ///< of each force in c, after the controls; the number of all at the end
  std::vector<int> first_control_switch_;  ///< of each control, and their number at the end
  std::vector<int> algebraic_, coupled_measures_;
  std::vector<int> first_switch_;      ///< of each force among the switches, and their number at the end
  std::vector<Condition> conditions_;  ///< the last of the switches
  std::vector<std::shared_ptr<const TimeFunction>> functions_of_time_;
  std::vector<std::shared_ptr<const MotionFunction>> functions_of_motion_;
  std::vector<CurveLaw> curves_;  ///< of forces
  std::vector<SignalSource> sources_;
};

}  // namespace flexura::mbs
