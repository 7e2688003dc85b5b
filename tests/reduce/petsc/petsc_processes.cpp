// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Under mpirun: eigenvalues of a grid's Laplacian by the eigensolver type "blocklanczos", all processes together.
#include <slepceps.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>
#include <vector>

#include "reduce/linalg/petsc/petsc_check.hpp"
#include "reduce/linalg/session/session.hpp"

namespace {

void ok(PetscErrorCode code) {
  flexura::linalg::petsc_check(code, "testing");
}

int run() {
  const flexura::linalg::Session session;
  const PetscInt n = 24, count = 24;
  Mat A = nullptr;
  ok(MatCreateAIJ(PETSC_COMM_WORLD, PETSC_DECIDE, PETSC_DECIDE, n * n, n * n, 5, nullptr, 4, nullptr, &A));
  PetscInt first = 0, last = 0;
  ok(MatGetOwnershipRange(A, &first, &last));
  for (PetscInt i = first; i < last; ++i) {
    ok(MatSetValue(A, i, i, 4.0, INSERT_VALUES));
    if (i % n + 1 < n) ok(MatSetValue(A, i, i + 1, -1.0, INSERT_VALUES));
    if (i % n > 0) ok(MatSetValue(A, i, i - 1, -1.0, INSERT_VALUES));
    if (i + n < n * n) ok(MatSetValue(A, i, i + n, -1.0, INSERT_VALUES));
    if (i >= n) ok(MatSetValue(A, i, i - n, -1.0, INSERT_VALUES));
  }
  ok(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  ok(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  ok(MatSetOption(A, MAT_SYMMETRIC, PETSC_TRUE));
  EPS eps = nullptr;
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  ok(EPSCreate(PETSC_COMM_WORLD, &eps));
  ok(EPSSetOperators(eps, A, nullptr));
  ok(EPSSetProblemType(eps, EPS_HEP));
  ok(EPSSetType(eps, "blocklanczos"));
  ok(EPSSetDimensions(eps, count, PETSC_DEFAULT, PETSC_DEFAULT));
  ok(EPSSetTolerances(eps, 1e-11, PETSC_DEFAULT));
  ok(EPSSetTarget(eps, 0.0));
  ok(EPSGetST(eps, &st));
  ok(STSetType(st, STSINVERT));
  ok(STGetKSP(st, &ksp));
  ok(KSPSetType(ksp, KSPPREONLY));
  ok(KSPGetPC(ksp, &pc));
  ok(PCSetType(pc, PCCHOLESKY));
  ok(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  ok(EPSSolve(eps));
  std::vector<double> exact;
  const double h = std::numbers::pi / (n + 1);
  for (int i = 1; i <= n; ++i)
    for (int j = 1; j <= n; ++j) exact.push_back(4.0 - 2.0 * std::cos(i * h) - 2.0 * std::cos(j * h));
  std::sort(exact.begin(), exact.end());
  PetscInt found = 0, right = 0;
  ok(EPSGetConverged(eps, &found));
  for (PetscInt k = 0; k < std::min(found, count); ++k) {
    PetscScalar value = 0.0;
    PetscReal error = 1.0;
    ok(EPSGetEigenvalue(eps, k, &value, nullptr));
    ok(EPSComputeError(eps, k, EPS_ERROR_ABSOLUTE, &error));
    // To round-off, some ulps of the largest eigenvalue (8), as with one process.
    if (std::abs(value - exact[k]) < 1e-13 && error < 1e-8) ++right;
  }
  int size = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  ok(PetscPrintf(PETSC_COMM_WORLD, "%d processes, %d of %d eigenvalues are exact\n", size,
                 static_cast<int>(right), static_cast<int>(count)));
  ok(EPSDestroy(&eps));
  ok(MatDestroy(&A));
  return right == count ? 0 : 1;
}

}  // namespace

int main() {
  try {
    return run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
}
