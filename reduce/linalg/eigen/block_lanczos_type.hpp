// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Only for the .cpp files of this folder that see SLEPc.
#include <slepceps.h>

#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"

/// Block Lanczos (block_lanczos.hpp) as an eigensolver type of SLEPc, beside its own:
///
///     EPSSetType(eps, "blocklanczos")        -eps_type blocklanczos -eps_blocklanczos_block 8
///
/// For Hermitian problems K x = lambda M x, M positive definite (EPS_HEP, EPS_GHEP), by shift-and-invert: the ST is
/// STSINVERT with a shift below the spectrum, whose KSP solves blocks of right-hand sides (KSPMatSolve); the basis is
/// the EPS's BV.  Finds the lowest eigenvalues, clusters at the end whole, so nconv may be more than nev.  The
/// processes of the EPS's communicator share the vectors' rows.
namespace flexura::linalg {

inline constexpr const char* kBlockLanczos = "blocklanczos";

/// Tells SLEPc of it; once, after SLEPc has started.
void register_block_lanczos();

/// What SLEPc's interface has no words for, of a problem that is computed by one process.
struct BlockLanczosContext {
  const EigenProblem* problem = nullptr;  ///< its products, projections and n_free are used; the ST solves
  EigenRequest request;
  Progress progress;
  EigenPairs pairs;  ///< what came out
};
/// For an EPS of this type; the context must outlive EPSSolve.
void set_context(EPS eps, BlockLanczosContext& context);

}  // namespace flexura::linalg
