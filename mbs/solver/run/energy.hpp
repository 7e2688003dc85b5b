// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "mbs/equations/equations.hpp"

/// The energy book of a run:
///
///     E(t) = kinetic + strain + potential = E(t_0) + work_in - dissipated + error
///
/// The powers are integrated over each step by four Lobatto points on the integrator's own polynomial (exact
/// to degree five, the highest order of the integrators), so the error left is that of the trajectory.
/// Between the ends of a step the integral is that of the cubic through these four powers.
///
/// What drives do is known better than by a polynomial: between the nodes of a long step it lies off the constraints
/// (a driven loop is right at the nodes of a step of a tenth of a turn), and near a position where they lose rank the
/// power has a peak far shorter than the step. There the powers are those of states that were moved onto the
/// constraints, and a step is halved until its four powers resolve it.
namespace flexura::mbs {

/// A moment of a run.
struct Instant {
  State state;
  Eigen::VectorXd v_dot;
};

struct EnergyAccount {
  EnergyReport now;         ///< at the time of the last call
  double start = 0.0;       ///< E(t_0) [J]
  double work_in = 0.0;     ///< integral of input_power [J]
  double dissipated = 0.0;  ///< integral of dissipated_power, and what impacts took [J]
  double gross_work = 0.0;  ///< integral of |input_power| [J]
  double peak = 0.0;        ///< largest |E - E(t_0)| and largest kinetic energy so far [J]
  double round_off = 0.0;   ///< kinetic energy of round-off speeds [J]; 0: not known yet

  double total() const { return now.kinetic + now.strain + now.potential; }
  double error() const { return total() - start - work_in + dissipated; }
  /// error() relative to the energy that was moved: the larger of the work put in and the peak; 0 where that is
  /// no more than round-off.
  double relative_error() const;
};

class EnergyBook {
 public:
  /// A state of the open step at its share x, 0 to 1, on the constraints and with its multipliers.
  using Between = std::function<const Instant&(double x)>;

  /// `tolerance` is what the work of a step may lack, relative to the energy that was moved.
  EnergyBook(const Equations& eq, double tolerance);

  void start(const State& s, const Eigen::VectorXd& v_dot);
  /// Goes on from the account of an earlier part of the run.
  void resume(const EnergyAccount& account, double t);
  /// Where a step from t_begin to t_end is looked at, the last is the end itself.
  static std::array<double, 3> node_times(double t_begin, double t_end);
  /// Takes the integrator's next step, which ends at t_end, by what its polynomial says at node_times(). Rows
  /// within the step are asked for before it is closed. With `between` it is halved where four powers say too little.
  void open_step(double t_end, const std::array<Instant, 3>& nodes, const Between& between = {});
  /// Fills `at` by the cubic through the step's begin and its three nodes.
  static void interpolate(const Instant& begin, const std::array<Instant, 3>& nodes, double x, Instant& at);
  /// Whether constraints that move by themselves do work at this state, which is that of their multipliers.
  /// Those of an integrator's polynomial answer to no error test: a wheel that a drive turns evenly took steps
  /// of a tenth of a turn, exact in its motion, whose account was open by 2 %.
  bool asks_multipliers(const State& s);
  EnergyAccount at_row(const State& s, const Eigen::VectorXd& v_dot);
  void close_step();
  /// Velocities (or the state of springs) jumped at a switch: the difference counts as dissipated where it is
  /// a loss, else as work put in.
  void jump(const State& s, const Eigen::VectorXd& v_dot);

  const EnergyAccount& account() const { return account_; }

 private:
  void look(const EnergyReport& now, EnergyAccount& account) const;
  double round_off_energy(const State& s, const Eigen::VectorXd& v_dot) const;

  const Equations& eq_;
  std::unique_ptr<Equations::Scratch> scratch_;
  // A part of the open step with what was seen at its four points.
  struct Part {
    double begin = 0.0, length = 1.0;
    std::array<EnergyReport, 4> at;
  };
  double unresolved(const Part& part) const;
  void halve(std::size_t k, const Between& between);
  void add(double x, EnergyAccount& account) const;  // the share x of the open step

  double tolerance_;
  EnergyAccount account_;
  double t_ = 0.0, t_end_ = 0.0, h_ = 0.0;
  std::vector<Part> parts_;  // of the open step, in their order
  Eigen::VectorXd g_t_, rest_;
};

}  // namespace flexura::mbs
