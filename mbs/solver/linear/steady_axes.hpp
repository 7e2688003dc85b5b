// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/algebra/accelerations.hpp"

/// Axes in which a motion may be steady, and where it then goes.
namespace flexura::mbs {

struct TurningAxes {
  Eigen::MatrixXd W;  ///< v' = W v of a motion that is steady in them: Mechanism::turning_axes
  std::string name;
  bool accelerated = false;  ///< v' is constant in place of v
};

/// A state with its accelerations and the rates of its dynamic states.
struct MovingState {
  const State& s;
  const Eigen::VectorXd &v_dot, &c_rate;
};

/// exp(t W), where few rows of W hold anything.
Eigen::MatrixXd turned(const Eigen::MatrixXd& W, double t);

/// The state tau later, if the motion is steady in these axes.
State along(const Mechanism& m, const MovingState& from, const TurningAxes& axes, double tau);

/// Resting axes, those that turn with the bodies, with each of them, with their precessions.
std::vector<TurningAxes> candidate_axes(const Mechanism& m, const State& s, const Eigen::VectorXd& v_dot,
                                        AccelerationSolver& accelerations, Equations::Scratch& scratch);

}  // namespace flexura::mbs
