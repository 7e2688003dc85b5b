// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/linalg/eigen/eigen_problem.hpp"

namespace flexura::linalg {

/// Whether a dense solution is what suits: few dofs, or modes that are a good part of all there are.
bool is_dense(const EigenProblem& problem, const EigenRequest& request);

/// Whether a dense solution can be afforded: at most some thousand dofs, all of them here.
bool may_be_dense(const EigenProblem& problem);

/// The pairs by LAPACK, of M phi = mu (K + sigma M) phi with sigma amid the spectrum: the lowest and the highest are known to
/// round-off times the ratio of their frequencies.  Polished and measured as all are; std::runtime_error where that does not make
/// them accurate.
EigenPairs dense_pairs(const EigenProblem& problem, const EigenRequest& request);

}  // namespace flexura::linalg
