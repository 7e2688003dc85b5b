// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/solver/run/run.hpp"

/// What happens where switching functions fell below 0: switches change and are written down, and with them conditions of
/// formulas that look at what they changed.  What switches to and fro without end is stopped.
namespace flexura::mbs {

class SwitchEvents {
 public:
  /// `scratch` is of eq; both must outlive it.
  SwitchEvents(const Equations& eq, Equations::Scratch& scratch, const SolverOptions& options);

  /// Changes the switches at the state s, and all that follow at once.  Throws IntegrationError where one switches without end.
  void take(const std::vector<int>& roots, State& s, std::vector<RootEvent>& events);

 private:
  double at_once(int which, double t) const;
  int times_at_once(int which, double t, const std::vector<RootEvent>& events) const;
  void change(const std::vector<int>& roots, State& s, std::vector<RootEvent>& events);
  void give_hysteresis(const std::vector<int>& roots, State& s, const std::vector<RootEvent>& events);
  void end_endless(int which, State& s, const std::vector<RootEvent>& events) const;

  const Equations& eq_;
  Equations::Scratch& scratch_;
  double duration_;  // of the run [s]
  Eigen::VectorXd values_;
};

}  // namespace flexura::mbs
