// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/equations/equations.hpp"
#include "mbs/solver/accuracy/options.hpp"

namespace flexura::mbs {

/// How independent the constraint rows are at s: 1 where they are orthogonal, 0 where one depends on the others.
/// `rank`: of them, may be null.
double independence_of_rows(const Equations& eq, const State& s, Equations::Scratch& scratch, int* rank);

/// What the weakest of the kept rows holds beside the others, in parts of the strongest, each measured by its size: a row that
/// vanishes for an instant is as bad as one that depends on others.
double hold_of_rows(const Equations& eq, const State& s, Equations::Scratch& scratch);

/// At rest, and every freedom is held by rows that do not move: there is nothing to integrate, and what an integrator
/// makes of the round-off of such rows has no smallest step (IDA: 1e-9 s, for minutes).
bool stands_still(const Equations& eq, const SolverOptions& options, const State& s,
                  Equations::Scratch& scratch);

}  // namespace flexura::mbs
