// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/integrators/integrator.hpp"

namespace flexura::mbs {

/// Radau IIA of three stages and order five (E. Hairer, G. Wanner, Solving Ordinary Differential Equations
/// II, 2nd ed., IV.8 and VII) on the stabilised index-2 form F(t, y, y') = 0:
///
///     F(t_0 + c_i h, y_0 + Z_i, (1/h) sum_j B_ij Z_j) = 0,   i = 1..3,   B = A^-1,     y_1 = y_0 + Z_3
///
/// Its solution decays at infinite frequency (L-stable) and no frequency grows, whatever the damping, where
/// BDF of order three to five is unstable for weakly damped vibration.
///
/// Newton's method on the eigenvectors of B: one real system at cj = gamma/h and one complex at cj = lambda/h
/// for each iteration; where the matrix changes too much from stage to stage for that, one for each stage
/// (radau_stages.hpp).  The error estimate (1/h gamma F_y' + F_y)^-1 F_y' (y_0' + (1/h) sum_i e_i Z_i) is of
/// order three; so that the tolerance means about the same as for the other methods it is met in the form 0.1
/// tolerance^(2/3), as in RADAU5.  Multipliers are kept out of the error test.
std::unique_ptr<Integrator> make_radau(const Equations& eq, const SolverOptions& options);

}  // namespace flexura::mbs
