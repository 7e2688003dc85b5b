// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"

/// Lowest eigenpairs by an EPS of SLEPc, whose type is the user's choice (`-eps_type`, petsc_options.hpp) or else
/// the one that the function says.  Whatever has computed them: pairs are made M-orthonormal to round-off, cut to
/// the request, their residuals are measured with K and M themselves, and inverse iteration mends what is not
/// accurate enough.  std::runtime_error, naming what was reached, where that does not help or not all converge.
namespace flexura::linalg {

/// Block Lanczos (block_lanczos.hpp): right-hand sides are solved for in blocks.
EigenPairs block_lanczos(const EigenProblem& problem, const EigenRequest& request,
                         const Progress& progress = {});

/// SLEPc's Krylov-Schur method, one right-hand side at a time.  G. W. Stewart, SIAM J. Matrix Anal. Appl. 23
/// (2001), 601; J. E. Roman, SLEPc technical report STR-7.
EigenPairs krylov_schur(const EigenProblem& problem, const EigenRequest& request,
                        const Progress& progress = {});

/// Makes ready what block_lanczos would, so that the user's options are read, and solves nothing.
void read_options(const EigenProblem& problem);

}  // namespace flexura::linalg
