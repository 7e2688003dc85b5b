// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/integrators/integrator.hpp"

namespace flexura::mbs {

/// Motion that constraints and drives prescribe wholly: positions, velocities and accelerations from g = 0
/// and its derivatives at every output time, multipliers from the momentum rows (what the drives must give).
/// Throws std::invalid_argument, naming coordinates, where a freedom is left that nothing drives or where
/// there are dynamic states.
std::unique_ptr<Integrator> make_kinematics(const Equations& eq, const SolverOptions& options);

/// Equilibria at every output time (statics.hpp), each sought from the one before: loads and drives that
/// change so slowly that nothing vibrates.  Velocities and accelerations are zero.
std::unique_ptr<Integrator> make_quasi_statics(const Equations& eq, const SolverOptions& options);

/// A mechanism without states (a body that is welded to the ground): only the time goes on.  SUNDIALS knows
/// no empty system.
std::unique_ptr<Integrator> make_rest();

}  // namespace flexura::mbs
