// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mbs/solver/integrators/integrator.hpp"

namespace flexura::mbs {

/// The integrator of options.method; `eq` must live longer.
std::unique_ptr<Integrator> make_integrator(const Equations& eq, const SolverOptions& options);

}  // namespace flexura::mbs
