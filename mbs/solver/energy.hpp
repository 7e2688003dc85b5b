// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "mbs/model/equations.hpp"
#include "mbs/solver/integrator.hpp"

/// The energy book of a run:
///
///     E(t) = kinetic + strain + potential = E(t_0) + work_in - dissipated + error
///
/// The powers are integrated over each step by four Lobatto points on the integrator's own polynomial (exact
/// to degree five, the highest order of the integrators), so the error left is that of the trajectory.
namespace flexura::mbs {

struct EnergyAccount {
  EnergyReport now;         ///< at the time of the last call
  double start = 0.0;       ///< E(t_0) [J]
  double work_in = 0.0;     ///< integral of input_power [J]
  double dissipated = 0.0;  ///< integral of dissipated_power, and what impacts took [J]
  double gross_work = 0.0;  ///< integral of |input_power| [J]
  double peak = 0.0;        ///< largest |E - E(t_0)| and largest kinetic energy so far [J]

  double total() const { return now.kinetic + now.strain + now.potential; }
  double error() const { return total() - start - work_in + dissipated; }
  /// error() relative to the energy that was moved: the larger of the work put in and the peak.
  double relative_error() const;
};

class EnergyBook {
 public:
  explicit EnergyBook(const Equations& eq);

  void start(const State& s, const Eigen::VectorXd& v_dot);
  /// Goes on from the account of an earlier part of the run.
  void resume(const EnergyAccount& account, const State& s, const Eigen::VectorXd& v_dot);
  /// Integrates up to t, which lies in the integrator's last step, and evaluates the energies at the state s
  /// there.
  void advance(double t, Integrator& integrator, const State& s, const Eigen::VectorXd& v_dot);
  /// Velocities (or the state of springs) jumped at a switch: the difference counts as dissipated.
  void jump(const State& s, const Eigen::VectorXd& v_dot);

  const EnergyAccount& account() const { return account_; }

 private:
  void look(const State& s, const Eigen::VectorXd& v_dot);

  const Equations& eq_;
  std::unique_ptr<Equations::Scratch> scratch_;
  EnergyAccount account_;
  double t_ = 0.0;
  State s_;
  Eigen::VectorXd v_dot_;
};

}  // namespace flexura::mbs
