// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/assemble.hpp"

/// Initial values of the elastic coordinates s from which no vibration starts: the deformation that follows
/// the loads of the motion as if without inertia of its own,
///
///     0 = (M v' - f + G^T lambda)_s   at s'' = 0,      s' = ds/dt along the motion,
///
/// with v' of the other coordinates and lambda those of the motion at s'' = 0.  What is left is of second
/// order in the ratio of the motion's rates to the natural frequencies.
namespace flexura::mbs {

/// Moves the elastic coordinates (Equations::elastic_coordinate) of the assembled state s and their rates
/// there, closes the loops by the other coordinates, and gives consistent v_dot, lambda.  `keep` as for
/// assemble(). Returns the number of iterations.  Throws AssemblyError where loops close through the
/// deformation alone or the iteration does not converge.
int settle(const Equations& eq, State& s, Eigen::VectorXd& v_dot, const AssembleOptions& keep = {});

}  // namespace flexura::mbs
