// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/integrators/integrator.hpp"

namespace flexura::mbs {

/// The generalised-alpha method of J. Chung and G. M. Hulbert (J. Appl. Mech. 60 (1993) 371-375) on the
/// equations of index 3, with the increments of rotations taken on their manifold (M. Arnold, O. Bruls, A.
/// Cardona, Numer. Math. 129 (2015) 149-179).  With h the step and w the method's own accelerations,
///
///     (1 - alpha_m) w_1 + alpha_m w_0 = (1 - alpha_f) v_1' + alpha_f v_0'
///     v_1 = v_0 + h ((1 - gamma) w_0 + gamma w_1)
///     p_1 = retract(p_0, d),   d = h v_0 + h^2 ((1/2 - beta) w_0 + beta w_1)
///     r(p_1, v_1, v_1', lambda_1) = 0,   g(p_1) = 0   (G v_1 + g_t = 0 for a row without a position level)
///
/// alpha_m, alpha_f, beta, gamma follow from rho_inf, the share of vibration at infinite frequency that is
/// left after a step.  w_0 belongs to the time t_0 + delta h, delta = alpha_m - alpha_f; when h changes it is
/// moved along, w_0 <- v_0' + (h / h_old) (w_0 - v_0'), and starts with the jerk, which keeps order 2 in the
/// multipliers too.  Dynamic states follow the same rule of first order; algebraic equations hold at the end
/// of the step.
///
/// Local errors, from the Taylor expansion of the lines above:
///     p:  (beta + delta / 2 - 1/6) h^2 (w_1 - w_0)
///     v:  C_v h^3 v''',   C_v = ((1 - gamma) delta^2 + gamma (1 + delta)^2) / 2 + e - 1/6,
///         e = ((1 - alpha_f) - (1 - alpha_m) (1 + delta)^2 - alpha_m delta^2) / 2
/// Both pass through Newton's matrix before they are measured: what a change of step leaves along the
/// constraints and in vibrations far beyond the step dies out by itself. Positions stay on their constraints
/// to Newton's tolerance, velocities to the method's error.
std::unique_ptr<Integrator> make_generalised_alpha(const Equations& eq, const SolverOptions& options);

}  // namespace flexura::mbs
