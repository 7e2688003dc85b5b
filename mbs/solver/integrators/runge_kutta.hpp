// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/integrators/integrator.hpp"

namespace flexura::mbs {

/// The explicit formalism for models that are not stiff: v' and lambda from the equations of index 1, p, v
/// and c by the Runge-Kutta pair 5(4) of J. R. Dormand and P. J. Prince (J. Comput. Appl. Math. 6 (1980)
/// 19-26) with its continuous extension of order 4 (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary
/// Differential Equations I, II.6), and after each step a projection of p and v onto the constraints by the
/// smallest change in the norm of M. With options.fixed_step the step is fixed and errors are not looked at
/// (real time).
std::unique_ptr<Integrator> make_runge_kutta(const Equations& eq, const SolverOptions& options);

}  // namespace flexura::mbs
