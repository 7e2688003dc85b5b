// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/integrators/integrator.hpp"

namespace flexura::mbs {

/// Kineto-elastodynamics of a mechanism whose drives prescribe the whole motion (A. G. Erdman, G. N. Sandor, Mechanism and
/// Machine Theory 7 (1972), 19): the nominal motion p_0(t) of undeformed bodies, found from the drives, and small deviations
/// d of all coordinates from it, elastic ones and those by which deformation moves what hangs on it, assembled at each
/// position,
///
///     M d'' + C d' + K d + G^T dlambda = -r_0,     G d = 0,     p = p_0 + d
///
/// with r_0 = M v_0' - f + G^T lambda_0 what the nominal motion leaves unbalanced (elastic rows alone: loads and inertia on the
/// bodies), and M, C = dr/dv, K = dr/dp, G those at the nominal state.  d does not act back on the nominal motion: right to first
/// order in d.  By generalised-alpha on index 3 (M. Arnold, O. Bruels, Multibody System Dynamics 18 (2007), 185), a linear system in
/// each step, whose length follows the local error h^2 |beta - 1/6| |a_1 - a_0| (O. C. Zienkiewicz, Y. M. Xie 1991).
///
/// Throws std::invalid_argument, by name, for freedoms that nothing drives, for dynamic and algebraic states, switches, driven
/// speeds, and orientations by quaternions.
std::unique_ptr<Integrator> make_elastodynamics(const Equations& eq, const SolverOptions& options);

}  // namespace flexura::mbs
