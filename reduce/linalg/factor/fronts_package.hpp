// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Only for the .cpp files of this folder that see PETSc.
#include <petscmat.h>

#include "reduce/linalg/dense/factor_figures.hpp"
#include "reduce/linalg/factor/fronts_hints.hpp"
#include "reduce/linalg/factor/supernodal_factor.hpp"

/// The multifrontal factorisation (supernodal_factor.hpp) as a solver package of PETSc, beside its own,
/// CHOLMOD's and MUMPS':
///
///     MatGetFactor(A, "fronts", MAT_FACTOR_CHOLESKY, &F)        -pc_factor_mat_solver_type fronts
///
/// A is of one process, SBAIJ of block size 1, every diagonal entry stored.  Groups of rows with the same
/// pattern are A's variable block sizes (MatSetVariableBlockSizes): the ordering is found on them.  Another
/// ordering is the IS of MatCholeskyFactorSymbolic.
///
/// Where A is known as positive definite (MAT_SPD) the factor is Cholesky's, and a pivot that is not positive
/// or zero to round-off is MAT_FACTOR_NUMERIC_ZEROPIVOT with its row.  Otherwise it is L S L^T without
/// pivoting, put to the test of inertia.hpp; a factor that fails it is MAT_FACTOR_NUMERIC_ZEROPIVOT, too.
/// MatSolve, MatMatSolve (all columns together, without copies of them) and MatGetInertia work on it.
/// `-mat_fronts_storage automatic|memory|file` says where it is kept (factor_store.hpp), `-mat_fronts_precision
/// double|single` in which precision.
/// A factor in single precision that fails the test is computed anew in double precision.
namespace flexura::linalg {

inline constexpr const char* kFronts = "fronts";

/// Tells PETSc of it; once, after PETSc has started.
void register_fronts();

/// Given to A before its factor is asked for.
void set_hints(Mat A, FrontsHints hints);

/// What stands behind a factor of this package.
struct FrontsFactor {
  SupernodalFactor L;
  FactorFigures figures;
};
/// Null where F is another package's, or not computed.
const FrontsFactor* fronts_factor(Mat F);

}  // namespace flexura::linalg
