// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/integrators/integrator.hpp"

namespace flexura::mbs {

/// BDF of variable step and order (SUNDIALS IDA; A. C. Hindmarsh et al., ACM TOMS 31 (2005) 363-396) on the
/// stabilised index-2 form, with roots located by IDA and multipliers kept out of the error test
/// (IDASetSuppressAlg).
/// Error weights: error_weights.hpp.
std::unique_ptr<Integrator> make_ida(const Equations& eq, const SolverOptions& options);

}  // namespace flexura::mbs
