// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/base/terminal/terminal.hpp"

/// eigen --buckling: factors of weight and given forces at which the equilibrium loses its stiffness.
namespace flexura::app {

/// Prints the table of each run, or JSON; at most `count` factors.  Returns the exit code.
int print_buckling(const MechanismArguments& arguments, int count, bool as_json,
                   const terminal::Verbosity& verbosity);

}  // namespace flexura::app
