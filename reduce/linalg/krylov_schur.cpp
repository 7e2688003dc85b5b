// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/krylov_schur.hpp"

#include <fmt/format.h>
#include <slepceps.h>

#include <algorithm>
#include <exception>
#include <random>
#include <stdexcept>

#include "reduce/linalg/petsc_check.hpp"

namespace flexura::linalg {
namespace {

// What PETSc's callbacks see.  C++ exceptions do not travel through C code: they wait here.
struct Shell {
  const EigenProblem* problem;
  std::exception_ptr error;
  int n_solves = 0;
};

PetscErrorCode apply(Shell& shell, const EigenProblem::Operator& op, Vec x, Vec y) {
  const PetscScalar* in = nullptr;
  PetscScalar* out = nullptr;
  if (PetscErrorCode code = VecGetArrayRead(x, &in)) return code;
  if (PetscErrorCode code = VecGetArray(y, &out)) return code;
  PetscErrorCode result = 0;
  try {
    const int n = shell.problem->n;
    Eigen::MatrixXd Y;
    op(Eigen::Map<const Eigen::MatrixXd>(in, n, 1), Y);
    Eigen::Map<Eigen::MatrixXd>(out, n, 1) = Y;
  } catch (...) {
    shell.error = std::current_exception();
    result = PETSC_ERR_LIB;
  }
  VecRestoreArrayRead(x, &in);
  VecRestoreArray(y, &out);
  return result;
}

PetscErrorCode apply_K(Mat mat, Vec x, Vec y) {
  void* context = nullptr;
  MatShellGetContext(mat, &context);
  auto& shell = *static_cast<Shell*>(context);
  return apply(shell, shell.problem->multiply_K, x, y);
}

PetscErrorCode apply_M(Mat mat, Vec x, Vec y) {
  void* context = nullptr;
  MatShellGetContext(mat, &context);
  auto& shell = *static_cast<Shell*>(context);
  return apply(shell, shell.problem->multiply_M, x, y);
}

PetscErrorCode apply_solve(PC pc, Vec x, Vec y) {
  void* context = nullptr;
  PCShellGetContext(pc, &context);
  auto& shell = *static_cast<Shell*>(context);
  ++shell.n_solves;
  return apply(shell, shell.problem->solve, x, y);
}

// The PETSc objects of one run, destroyed whatever happens.
struct Objects {
  Mat K = nullptr, M = nullptr;
  Vec x = nullptr;
  EPS eps = nullptr;
  ~Objects() {
    if (eps) EPSDestroy(&eps);
    if (x) VecDestroy(&x);
    if (K) MatDestroy(&K);
    if (M) MatDestroy(&M);
  }
};

void check(PetscErrorCode code, Shell& shell, const char* doing) {
  if (code != 0 && shell.error) std::rethrow_exception(shell.error);
  petsc_check(code, doing);
}

EigenPairs solve_for(const EigenProblem& problem, int count, double tolerance) {
  Shell shell{&problem, nullptr};
  Objects o;
  const int n = problem.n;
  const char* doing = "setting up the eigensolver";
  const auto ok = [&](PetscErrorCode code) { check(code, shell, doing); };
  ok(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, &shell, &o.K));
  ok(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, &shell, &o.M));
  ok(MatShellSetOperation(o.K, MATOP_MULT, reinterpret_cast<void (*)()>(apply_K)));
  ok(MatShellSetOperation(o.M, MATOP_MULT, reinterpret_cast<void (*)()>(apply_M)));
  ok(EPSCreate(PETSC_COMM_SELF, &o.eps));
  ok(EPSSetOperators(o.eps, o.K, o.M));
  ok(EPSSetProblemType(o.eps, EPS_GHEP));
  ok(EPSSetType(o.eps, EPSKRYLOVSCHUR));
  ok(EPSSetTarget(o.eps, -problem.shift));
  ok(EPSSetWhichEigenpairs(o.eps, EPS_TARGET_MAGNITUDE));
  const int n_vectors = std::min(problem.n_free, std::max(2 * count, count + 20));
  ok(EPSSetDimensions(o.eps, std::min(count, problem.n_free), n_vectors, PETSC_DEFAULT));
  // The residual of K phi = omega^2 M phi is measured in a norm that stresses short waves: two digits in
  // hand.
  ok(EPSSetTolerances(o.eps, std::max(1e-2 * tolerance, 1e-14), 200));
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  ok(EPSGetST(o.eps, &st));
  ok(STSetType(st, STSINVERT));
  ok(STSetShift(st, -problem.shift));
  ok(STSetMatMode(st, ST_MATMODE_SHELL));
  ok(STGetKSP(st, &ksp));
  ok(KSPSetType(ksp, KSPPREONLY));
  ok(KSPGetPC(ksp, &pc));
  ok(PCSetType(pc, PCSHELL));
  ok(PCShellSetContext(pc, &shell));
  ok(PCShellSetApply(pc, apply_solve));
  // The starting vector goes through the operator first, so that it lies in the problem's space.
  Eigen::MatrixXd start(n, 1), MX, x;
  std::mt19937_64 random(20240229);
  std::normal_distribution<double> normal;
  for (double& entry : start.reshaped()) entry = normal(random);
  problem.multiply_M(start, MX);
  problem.solve(MX, x);
  ok(MatCreateVecs(o.K, &o.x, nullptr));
  PetscScalar* data = nullptr;
  ok(VecGetArray(o.x, &data));
  std::copy_n(x.data(), n, data);
  ok(VecRestoreArray(o.x, &data));
  ok(EPSSetInitialSpace(o.eps, 1, &o.x));
  doing = "computing eigenpairs";
  ok(EPSSolve(o.eps));
  PetscInt converged = 0;
  ok(EPSGetConverged(o.eps, &converged));
  if (converged < std::min(count, problem.n_free))
    throw std::runtime_error(
        fmt::format("Krylov-Schur: only {} of {} eigenpairs converged", converged, count));
  EigenPairs pairs;
  std::vector<std::pair<double, int>> order;
  for (int k = 0; k < converged; ++k) {
    PetscScalar value = 0.0;
    ok(EPSGetEigenvalue(o.eps, k, &value, nullptr));
    order.emplace_back(value, k);
  }
  std::sort(order.begin(), order.end());
  pairs.omega2.resize(converged);
  pairs.Phi.resize(n, converged);
  for (int k = 0; k < converged; ++k) {
    pairs.omega2(k) = order[k].first;
    ok(EPSGetEigenvector(o.eps, order[k].second, o.x, nullptr));
    const PetscScalar* values = nullptr;
    ok(VecGetArrayRead(o.x, &values));
    pairs.Phi.col(k) = Eigen::Map<const Eigen::VectorXd>(values, n);
    ok(VecRestoreArrayRead(o.x, &values));
  }
  pairs.n_solves = pairs.n_blocks = shell.n_solves + 1;
  return pairs;
}

}  // namespace

EigenPairs krylov_schur(const EigenProblem& problem, const EigenRequest& request, const Progress& progress) {
  require_session();
  int count = std::max(1, request.count);
  for (;;) {
    report(progress, "modes (Krylov-Schur)", 0.0);
    EigenPairs pairs = solve_for(problem, std::min(count + 2, problem.n_free), request.tolerance);
    const bool all = pairs.omega2.size() >= problem.n_free;
    if (all || pairs.omega2(pairs.omega2.size() - 1) > request.omega2_max) {
      trim(pairs, request);
      measure_residuals(problem, pairs);
      report(progress, "modes (Krylov-Schur)", 1.0);
      return pairs;
    }
    count *= 2;
  }
}

}  // namespace flexura::linalg
