// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/eigen/eigensolver.hpp"

#include <fmt/format.h>
#include <slepc/private/epsimpl.h>
#include <slepceps.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "reduce/linalg/eigen/block_lanczos_type.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"

namespace flexura::linalg {
namespace {

using Eigen::MatrixXd;

void ok(PetscErrorCode code) {
  petsc_check(code, "computing eigenpairs");
}

// What PETSc's callbacks see.
struct Shell {
  const EigenProblem& problem;
  // For methods that do not only take what `solve` gives, in a space smaller than that of the vectors: the projection P
  // into it, K' = P K P + stiffness (1 - P), M' = P M P + mass (1 - P).  Their eigenvectors out of the space have eigenvalues at
  // the upper end of the spectrum; without them round-off out of the space, where K and M vanish, would grow.
  bool project = false;
  double stiffness = 1.0, mass = 1.0;
  int n_solves = 0;
};

// Y = op(X) on PETSc's numbers; `beside`: of what lies out of the space.
PetscErrorCode apply(const Shell& shell, const EigenProblem::Operator& op, double beside,
                     const PetscScalar* X, PetscScalar* Y, Eigen::Index rows, Eigen::Index cols) {
  return guarded([&] {
    const Eigen::Map<const MatrixXd> x(X, rows, cols);
    MatrixXd y;
    if (shell.project) {
      MatrixXd inside = x;
      shell.problem.project(inside);
      op(inside, y);
      shell.problem.project(y);
      y += beside * (x - inside);
    } else {
      op(x, y);
    }
    Eigen::Map<MatrixXd>(Y, rows, cols) = y;
  });
}

PetscErrorCode apply(const Shell& shell, const EigenProblem::Operator& op, double beside, Vec x, Vec y) {
  PetscInt n = 0;
  const PetscScalar* in = nullptr;
  PetscScalar* out = nullptr;
  if (PetscErrorCode code = VecGetLocalSize(x, &n)) return code;
  if (PetscErrorCode code = VecGetArrayRead(x, &in)) return code;
  if (PetscErrorCode code = VecGetArrayWrite(y, &out)) return code;
  const PetscErrorCode code = apply(shell, op, beside, in, out, n, 1);
  VecRestoreArrayRead(x, &in);
  VecRestoreArrayWrite(y, &out);
  return code;
}

template <class Get, class Object>
Shell& shell_of(Get get, Object object) {
  void* context = nullptr;
  get(object, &context);
  return *static_cast<Shell*>(context);
}

PetscErrorCode multiply_K(Mat mat, Vec x, Vec y) {
  const Shell& shell = shell_of([](Mat m, void* c) { return MatShellGetContext(m, c); }, mat);
  return apply(shell, shell.problem.multiply_K, shell.stiffness, x, y);
}

PetscErrorCode multiply_M(Mat mat, Vec x, Vec y) {
  const Shell& shell = shell_of([](Mat m, void* c) { return MatShellGetContext(m, c); }, mat);
  return apply(shell, shell.problem.multiply_M, shell.mass, x, y);
}

PetscErrorCode solve_one(PC pc, Vec x, Vec y) {
  Shell& shell = shell_of([](PC p, void* c) { return PCShellGetContext(p, c); }, pc);
  ++shell.n_solves;
  return apply(shell, shell.problem.solve, 1.0 / shell.stiffness, x, y);
}

PetscErrorCode solve_block(PC pc, Mat X, Mat Y) {
  Shell& shell = shell_of([](PC p, void* c) { return PCShellGetContext(p, c); }, pc);
  PetscInt n = 0, k = 0, X_stride = 0, Y_stride = 0;
  const PetscScalar* in = nullptr;
  PetscScalar* out = nullptr;
  if (PetscErrorCode code = MatGetLocalSize(X, &n, nullptr)) return code;
  if (PetscErrorCode code = MatGetSize(X, nullptr, &k)) return code;
  if (PetscErrorCode code = MatDenseGetLDA(X, &X_stride)) return code;
  if (PetscErrorCode code = MatDenseGetLDA(Y, &Y_stride)) return code;
  if (n > 0 && (X_stride != n || Y_stride != n)) return PETSC_ERR_SUP;
  if (PetscErrorCode code = MatDenseGetArrayRead(X, &in)) return code;
  if (PetscErrorCode code = MatDenseGetArrayWrite(Y, &out)) return code;
  shell.n_solves += k;
  const PetscErrorCode code = apply(shell, shell.problem.solve, 1.0 / shell.stiffness, in, out, n, k);
  MatDenseRestoreArrayRead(X, &in);
  MatDenseRestoreArrayWrite(Y, &out);
  return code;
}

PetscErrorCode view_solve(PC pc, PetscViewer viewer) {
  const Shell& shell = shell_of([](PC p, void* c) { return PCShellGetContext(p, c); }, pc);
  return guarded([&] {
    if (!shell.problem.view) return;
    ok(PetscViewerASCIIPushTab(viewer));
    shell.problem.view(viewer);
    ok(PetscViewerASCIIPopTab(viewer));
  });
}

// The PETSc objects of one run.  What failed half-way is left to the end of the program: an EPS whose making ran out of
// memory crashes where it is destroyed (SLEPc 3.18, STReset).
struct Objects {
  int exceptions = std::uncaught_exceptions();
  Mat K = nullptr, M = nullptr;
  std::vector<Vec> start;
  EPS eps = nullptr;
  ~Objects() {
    if (!petsc_is_sound() || std::uncaught_exceptions() > exceptions) return;
    EPSDestroy(&eps);
    for (Vec& x : start) VecDestroy(&x);
    MatDestroy(&K);
    MatDestroy(&M);
  }
};

// The processes that hold the vectors' rows.
MPI_Comm processes_of(const EigenProblem& problem) {
  return problem.sum ? PETSC_COMM_WORLD : PETSC_COMM_SELF;
}

// A vector of the problem's space, random but for that.
Vec starting_vector(const EigenProblem& problem, Mat K, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  MatrixXd start(problem.n, 1), MX, x;
  for (double& entry : start.reshaped()) entry = normal(random);
  problem.multiply_M(start, MX);
  problem.solve(MX, x);
  Vec vector = nullptr;
  PetscScalar* data = nullptr;
  ok(MatCreateVecs(K, &vector, nullptr));
  ok(VecGetArray(vector, &data));
  std::copy_n(x.data(), problem.n, data);
  ok(VecRestoreArray(vector, &data));
  return vector;
}

std::string type_of(EPS eps) {
  EPSType type = nullptr;
  ok(EPSGetType(eps, &type));
  return type;
}

// The type that the user names, or else the given one.  It must be known before other options are read: what the
// spectral transformation is by default follows from it.
void set_type(EPS eps, const char* type) {
  char named[64] = "";
  PetscBool given = PETSC_FALSE;
  ok(PetscOptionsGetString(nullptr, nullptr, "-eps_type", named, sizeof(named), &given));
  ok(EPSSetType(eps, given ? named : type));
}

// Whether the method sees the inverse only; others multiply by K and M and take `solve` for a preconditioner.
bool inverts(EPS eps) {
  return eps->categ == EPS_CATEGORY_KRYLOV || eps->categ == EPS_CATEGORY_OTHER;
}

// Keeps the method in the problem's space.
void project(Shell& shell, std::mt19937_64& random) {
  const EigenProblem& problem = shell.problem;
  std::normal_distribution<double> normal;
  MatrixXd x(problem.n, 1), Kx, Mx;
  for (double& entry : x.reshaped()) entry = normal(random);
  problem.multiply_K(x, Kx);
  problem.multiply_M(x, Mx);
  const double size = problem.inner(x, x)(0, 0);
  shell.stiffness = std::sqrt(problem.inner(Kx, Kx)(0, 0) / size);
  shell.mass = std::sqrt(problem.inner(Mx, Mx)(0, 0) / size);
  shell.project = true;
}

void create(Objects& o, Shell& shell, const char* type, int count, double tolerance) {
  const EigenProblem& problem = shell.problem;
  const int n = problem.n;
  const MPI_Comm comm = processes_of(problem);
  for (Mat* mat : {&o.K, &o.M}) ok(MatCreateShell(comm, n, n, PETSC_DETERMINE, PETSC_DETERMINE, &shell, mat));
  ok(MatShellSetOperation(o.K, MATOP_MULT, reinterpret_cast<void (*)()>(multiply_K)));
  ok(MatShellSetOperation(o.M, MATOP_MULT, reinterpret_cast<void (*)()>(multiply_M)));
  for (Mat mat : {o.K, o.M}) ok(MatSetOption(mat, MAT_SYMMETRIC, PETSC_TRUE));
  ok(EPSCreate(comm, &o.eps));
  ok(EPSSetOperators(o.eps, o.K, o.M));
  ok(EPSSetProblemType(o.eps, EPS_GHEP));
  set_type(o.eps, type);
  const bool by_solves = inverts(o.eps);
  const bool blocks = type_of(o.eps) == kBlockLanczos;
  const int n_vectors = std::min(problem.n_free, std::max(2 * count, count + 20));
  ok(EPSSetDimensions(o.eps, std::min(count, problem.n_free),
                      blocks || !by_solves ? PETSC_DEFAULT : n_vectors, PETSC_DEFAULT));
  // The residual of K phi = omega^2 M phi is measured in a norm that stresses short waves: two digits in hand.
  ok(EPSSetTolerances(o.eps, std::max(1e-2 * tolerance, 1e-14), by_solves ? 2000 : 20000));
  ST st = nullptr;
  KSP ksp = nullptr;
  PC pc = nullptr;
  ok(EPSGetST(o.eps, &st));
  ok(STSetMatMode(st, ST_MATMODE_SHELL));
  if (by_solves) {
    ok(STSetType(st, STSINVERT));
    ok(STSetShift(st, -problem.shift));
    ok(EPSSetTarget(o.eps, -problem.shift));
    ok(EPSSetWhichEigenpairs(o.eps, EPS_TARGET_MAGNITUDE));
  } else {
    ok(EPSSetWhichEigenpairs(o.eps, EPS_SMALLEST_REAL));
  }
  ok(STGetKSP(st, &ksp));
  if (by_solves) ok(KSPSetType(ksp, KSPPREONLY));
  ok(KSPGetPC(ksp, &pc));
  ok(PCSetType(pc, PCSHELL));
  ok(PCShellSetContext(pc, &shell));
  ok(PCShellSetApply(pc, solve_one));
  ok(PCShellSetMatApply(pc, solve_block));
  ok(PCShellSetView(pc, view_solve));
  ok(PCShellSetName(pc, "the reduction's solver"));
  ok(EPSSetFromOptions(o.eps));
}

// What only this type or this number of modes cannot do is found here: it is the options that ask for it.
void set_up(EPS eps) {
  try {
    ok(EPSSetUp(eps));
  } catch (const PetscFailure& error) {
    if (!petsc_is_sound()) throw;
    throw std::invalid_argument(fmt::format(
        "the PETSc options do not suit these modes: {}; docs/petsc.md says which options make sense",
        error.what()));
  }
}

EigenPairs take_pairs(EPS eps, Mat K, int n) {
  PetscInt converged = 0;
  ok(EPSGetConverged(eps, &converged));
  std::vector<std::pair<double, int>> order;
  for (int k = 0; k < converged; ++k) {
    PetscScalar value = 0.0;
    ok(EPSGetEigenvalue(eps, k, &value, nullptr));
    order.emplace_back(value, k);
  }
  std::sort(order.begin(), order.end());
  EigenPairs pairs;
  pairs.omega2.resize(converged);
  pairs.Phi.resize(n, converged);
  Vec x = nullptr;
  ok(MatCreateVecs(K, &x, nullptr));
  for (int k = 0; k < converged; ++k) {
    pairs.omega2(k) = order[k].first;
    const PetscScalar* entries = nullptr;
    ok(EPSGetEigenvector(eps, order[k].second, x, nullptr));
    ok(VecGetArrayRead(x, &entries));
    std::copy_n(entries, n, pairs.Phi.col(k).data());
    ok(VecRestoreArrayRead(x, &entries));
  }
  ok(VecDestroy(&x));
  return pairs;
}

// The lowest `count` pairs, and what came with them.
EigenPairs solve_for(const EigenProblem& problem, const EigenRequest& request, int count, const char* type,
                     const Progress& progress) {
  Shell shell{problem};
  BlockLanczosContext context{&problem, request, progress, {}};
  Objects o;
  create(o, shell, type, count, request.tolerance);
  const std::string chosen = type_of(o.eps);
  if (chosen == kBlockLanczos) {
    set_context(o.eps, context);
    // The basis is as large as options ask for (-eps_ncv).
    PetscInt n_vectors = 0, most_projected = 0;
    ok(EPSGetDimensions(o.eps, nullptr, &n_vectors, &most_projected));
    ok(EPSSetDimensions(o.eps, std::max(1, std::min(request.count, problem.n_free)), n_vectors,
                        most_projected));
    set_up(o.eps);
    ok(EPSSolve(o.eps));
    return std::move(context.pairs);
  }
  report(progress, "modes (" + chosen + ")", 0.0);
  // Where averages hold the vectors a method must start in their space, with all the vectors that it starts with.
  std::mt19937_64 random(20240229 + static_cast<unsigned>(problem.rank));
  PetscInt n_start = 1, n_rows = 0;
  if (!inverts(o.eps)) ok(EPSGetDimensions(o.eps, &n_start, nullptr, nullptr));
  if (!inverts(o.eps) || chosen == EPSLAPACK) {  // LAPACK takes the inverse of all directions
    ok(MatGetSize(o.K, &n_rows, nullptr));
    if (problem.project && problem.n_free < n_rows) project(shell, random);
  }
  for (PetscInt k = 0; k < n_start; ++k) o.start.push_back(starting_vector(problem, o.K, random));
  ok(EPSSetInitialSpace(o.eps, n_start, o.start.data()));
  set_up(o.eps);
  try {
    ok(EPSSolve(o.eps));
  } catch (const PetscFailure& error) {
    if (!petsc_is_sound()) throw;
    throw std::runtime_error(
        fmt::format("SLEPc's {} does not find these modes: {}; ask for fewer, or take another eigensolver "
                    "(docs/petsc.md)",
                    chosen, error.what()));
  }
  EigenPairs pairs = take_pairs(o.eps, o.K, problem.n);
  const auto found = static_cast<int>(pairs.omega2.size());
  if (found < std::min(count, problem.n_free))
    throw std::runtime_error(
        fmt::format("SLEPc's {}: only {} of {} eigenpairs converged", chosen, found, count));
  pairs.n_solves = pairs.n_blocks = shell.n_solves + static_cast<int>(n_start);
  report(progress, "modes (" + chosen + ")", 1.0);
  return pairs;
}

// Pairs of any origin, cut to the request and put to the test that ours have passed while they were computed.
void finish(const EigenProblem& problem, const EigenRequest& request, EigenPairs& pairs) {
  trim(pairs, request);
  if (pairs.Phi.cols() == 0) return measure_residuals(problem, pairs);
  orthonormalise(problem, pairs.Phi);
  measure_residuals(problem, pairs);
  polish_until_accurate(problem, request.tolerance, pairs);
  if (!is_accurate(pairs, request.tolerance))
    throw std::runtime_error(fmt::format(
        "the worst residual of {} modes stays at {:.1e}, above {:.1e}: ask SLEPc for more accurate pairs "
        "(-eps_tol), or for another eigensolver",
        pairs.Phi.cols(), pairs.residual.maxCoeff(), request.tolerance));
}

EigenPairs solve(const EigenProblem& problem, const EigenRequest& request, const char* type,
                 const Progress& progress) {
  require_session();
  for (int count = std::max(1, request.count);; count *= 2) {
    EigenPairs pairs = solve_for(problem, request, std::min(count + 2, problem.n_free), type, progress);
    if (pairs.residual.size() > 0 || pairs.Phi.cols() == 0) return pairs;  // ours: all that is asked for
    const bool all = pairs.omega2.size() >= problem.n_free;
    if (all || pairs.omega2(pairs.omega2.size() - 1) > request.omega2_max) {
      finish(problem, request, pairs);
      return pairs;
    }
  }
}

}  // namespace

EigenPairs block_lanczos(const EigenProblem& problem, const EigenRequest& request, const Progress& progress) {
  return solve(problem, request, kBlockLanczos, progress);
}

void read_options(const EigenProblem& problem) {
  Shell shell{problem};
  Objects o;
  create(o, shell, kBlockLanczos, 1, 1e-9);
  // Types that cannot do it at all refuse to be set up; a basis as long as options ask for is longer than this problem.
  BlockLanczosContext context{&problem, {.count = 1}, {}, {}};
  if (type_of(o.eps) == kBlockLanczos) set_context(o.eps, context);
  ok(EPSSetDimensions(o.eps, 1, PETSC_DEFAULT, PETSC_DEFAULT));
  ok(EPSSetUp(o.eps));
}

EigenPairs krylov_schur(const EigenProblem& problem, const EigenRequest& request, const Progress& progress) {
  return solve(problem, request, EPSKRYLOVSCHUR, progress);
}

}  // namespace flexura::linalg
