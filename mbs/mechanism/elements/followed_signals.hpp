// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "mbs/mechanism/elements/constraint_rows.hpp"
#include "mbs/mechanism/elements/element_states.hpp"

/// What rows follow that are not functions of time: drives whose value is a signal.
///
///     q = y(c, t):     y' and y'' by the chain rule from c' = f_c of the controls and its derivatives
///     v = y(p, c, t):  y' alike
///
/// y'' must not hold accelerations: what a control of a position reads in its rate is known with its own rate only where
/// it is a coordinate, a measure of positions, time or another state.  y itself must not jump where it is a position; its
/// rate may, at an event, like that of a drive by time.
///
/// An algebraic state a, 0 = b(a, x), is eliminated: rows see the root next to the state's own value, whatever that lacks, and
///
///     a' = - b_x x' / b_a,    a'' = - (b_x x'' + (x', a')^T b'' (x', a')) / b_a
namespace flexura::mbs {

class FollowedSignals {
 public:
  using Level = TreeMotion::Level;

  /// Throws std::invalid_argument for a formula whose derivatives are not known, with the remedy.
  FollowedSignals(const Topology& tree, const ElementStates& states, const ConstraintRows& rows);
  bool any() const { return !followers_.empty(); }
  void size(FollowedValues& values) const;

  /// The formulas and their derivatives by time, into `rows`; after forward() on this level, take_states() and, from level
  /// velocity on, evaluate_signals().
  void evaluate(Level level, Motion& motion, Signals& signals, RowValues& rows) const;

  struct Follower {
    std::size_t constraint;  ///< among all
    std::size_t place;       ///< in FollowedValues::of_constraints
    Following what;
  };
  const std::vector<Follower>& followers() const { return followers_; }
  /// The places that are functions of a formula's signals, in the order of their evaluation.
  const std::vector<int>& places() const { return places_; }
  /// d h / d c_i of a control's output (n_states), in `weights`.
  void output_weights(int control, const Motion& motion, const Signals& signals,
                      Eigen::VectorXd& weights) const;

 private:
  using Kind = ElementStates::SignalSource::Kind;
  struct Unknown {
    std::string name, why;
  };
  void check(const Follower& follower) const;
  bool jumps(int place) const;
  std::optional<Unknown> find_unknown(int place, int order) const;
  std::optional<Unknown> find_dependent(int place) const;
  void need(int place, int order);
  /// What a signal is made of at once: what a measure, an algebraic state, a control that feeds through reads.
  std::vector<int> made_of(int place) const;
  void list_places();
  void order_by_reads(int place, std::vector<int>& state, std::vector<int>& list) const;
  const Control* algebraic(int place) const;
  void evaluate_place(int place, const Motion& motion, Signals& signals) const;
  double rate_of_coordinate(CoordinateRef c, const Motion& motion) const;
  void first_derivatives(bool all, Motion& motion, const Signals& signals, FollowedValues& values) const;
  void second_derivatives(const Motion& motion, const Signals& signals, FollowedValues& values) const;

  const Topology& tree_;
  const ElementStates& states_;
  std::vector<Follower> followers_;
  std::vector<int> order_;  ///< of each signal: the derivatives that are needed of it, -1: not even its value
  std::vector<int> places_;     ///< signals with an order of 0 at least, in the order of their evaluation
  std::vector<int> of_states_;  ///< those that positions follow: known from c and t alone
  bool eliminates_ = false;     ///< algebraic states
};

}  // namespace flexura::mbs
