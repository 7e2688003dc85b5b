// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/formulas/motion_function.hpp"
#include "mbs/solver/algebra/history.hpp"

/// Whether a step leapt over a peak of a force: a bump of a millimetre on a road of a kilometre, a detent, a tooth of a
/// magnet.  An integrator judges a step by the few states in it at which it asked for forces; where these are far from the
/// peak it sees nothing.
///
/// Along the step what formulas and curves read is a cubic through its four points.  Between these points a function f
/// should be what the cubic P through its own four values says, but for half of their range: where interval arithmetic on
/// smaller and smaller parts cannot prove that and the part holds a value beyond, the step ends there.  Of a peak in m
/// parts of a step that takes some log2(m) of them.  What is small beside the largest value that the function had so far is no
/// peak: the tails of a bell fall by powers of ten within a step, down to the smallest numbers.
namespace flexura::mbs {

class PeakWatch {
 public:
  explicit PeakWatch(const Equations& eq);
  bool watches() const { return !functions_.empty(); }

  using StateAt = std::function<void(double t, State& s)>;
  /// The part of the step, in [0, 1), from which on a function is not what the step has seen; nothing where all are.
  std::optional<double> look(double t_begin, double t_end, const StateAt& state_at);
  void remember(History& history);

 private:
  using Cubic = std::array<double, 4>;  // coefficients of powers of the place in the step
  IntervalJet over_part(const MotionFunction& f, double begin, double end);
  double at(const MotionFunction& f, double place);
  bool is_end_of_last_step(const State& s) const;
  std::optional<double> first_peak(const MotionFunction& f, double& largest_so_far);

  const Equations& eq_;
  std::vector<std::shared_ptr<const MotionFunction>> functions_;
  std::vector<int> reads_;  // arguments that any reads
  std::unique_ptr<Equations::Scratch> scratch_;
  Eigen::VectorXd largest_;               // of each function, at the points that were looked at
  State state_, end_;                     // at a node; at the last of the step before
  std::array<Eigen::VectorXd, 4> nodes_;  // arguments by their places
  Eigen::VectorXd place_;                 // likewise, between nodes
  std::vector<Cubic> paths_;              // by the places of arguments
  std::vector<IntervalJet> jets_;         // likewise
};

}  // namespace flexura::mbs
