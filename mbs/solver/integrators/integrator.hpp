// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "mbs/solver/algebra/history.hpp"

/// What every integrator offers: steps of its own choice, a polynomial in each step, stops at switches.
namespace flexura::mbs {

/// The integrator cannot go on; the text says why, where and at what time, in one sentence.
class IntegrationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct StepCounts {
  long steps = 0;
  long evaluations = 0;         ///< of the equations of motion
  long jacobians = 0;           ///< matrices built and factorised
  long error_failures = 0;      ///< steps repeated because of their error
  long newton_failures = 0;     ///< steps repeated because Newton did not converge
  long restarts = 0;            ///< at switches
  long singular_crossings = 0;  ///< explicit steps across positions where constraints lose rank, see run.cpp
};

struct StepEnd {
  double t_begin = 0.0, t_end = 0.0;
  std::vector<int> roots =
      {};                ///< switches whose functions fell below 0 at t_end; then call start() before step()
  double t_tried = 0.0;  ///< where a step that a switch cut short would have ended
};

class Integrator {
 public:
  virtual ~Integrator() = default;

  /// (Re)starts at a consistent state with accelerations v_dot (n_v).
  virtual void start(const State& s, const Eigen::VectorXd& v_dot) = 0;

  /// No state behind it is looked at by the next start(): something jumps there.
  void set_horizon(double t) { horizon_ = t; }

  /// One step, not beyond t_stop, where nothing behind it is looked at; ends early at a switch.  Throws
  /// IntegrationError.
  virtual StepEnd step(double t_stop) = 0;

  /// State and accelerations at t within the last step, from the integrator's own polynomial.
  virtual void interpolate(double t, State& s, Eigen::VectorXd& v_dot) = 0;

  virtual StepCounts counts() const = 0;

  /// Writes its memory into `history`, or takes it from there in place of start().
  virtual void remember(History& history) = 0;

 protected:
  double horizon_ = std::numeric_limits<double>::infinity();
};

}  // namespace flexura::mbs
