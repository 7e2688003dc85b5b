// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <petscmat.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"
#include "reduce/linalg/session/session.hpp"
#include "tests/benchmarks/solver_matrix.hpp"

/// Solver packages of PETSc on one stiffness matrix: the project's own (fronts), CHOLMOD, MUMPS with one and two
/// processes and with block low-rank factors.  bench_solvers NAME PART [SIZE] (solver_matrix.hpp); each package runs in a
/// process of its own, so that its memory can be told.
namespace flexura::reduce {
namespace {

struct Configuration {
  const char* name;
  const char* package;
  int processes, blas_threads;
  double low_rank;      ///< block low-rank factors dropped at this, relative to their blocks; 0: full factors
  bool single = false;  ///< fronts in single precision, solves refined
};

constexpr Configuration kConfigurations[] = {
    {"fronts", "fronts", 1, 1, 0.0},
    {"fronts_single", "fronts", 1, 1, 0.0, true},
    {"cholmod", "cholmod", 1, 1, 0.0},
    {"cholmod_2_threads", "cholmod", 1, 2, 0.0},
    {"mumps", "mumps", 1, 1, 0.0},
    {"mumps_2_threads", "mumps", 1, 2, 0.0},
    {"mumps_2_processes", "mumps", 2, 1, 0.0},
    {"mumps_low_rank_1e-8", "mumps", 1, 1, 1e-8},
    {"mumps_low_rank_1e-10", "mumps", 1, 1, 1e-10},
    {"mumps_low_rank_1e-12", "mumps", 1, 1, 1e-12},
};

void ok(PetscErrorCode code) {
  linalg::petsc_check(code, "comparing solvers");
}

// [bytes] of /proc/self/status, over all processes.
double memory(const char* what) {
  std::ifstream in("/proc/self/status");
  double kilobytes = 0.0, all = 0.0;
  for (std::string word; in >> word;)
    if (word == what) in >> kilobytes;
  MPI_Allreduce(&kilobytes, &all, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return 1024.0 * all;
}

double processor_seconds() {
  const double own = linalg::processor_seconds();
  double all = 0.0;
  MPI_Allreduce(&own, &all, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return all;
}

struct Spent {
  linalg::Stopwatch watch;
  double processor = processor_seconds();
  double seconds = 0.0, processor_s = 0.0;
  void stop() {
    seconds = watch.lap();
    processor_s = processor_seconds() - processor;
  }
};

// The rows of this process, consecutive ones.
Mat create(const SolverMatrix& A) {
  int rank = 0, size = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &size);
  const PetscInt n = A.size(), first = n / size * rank, end = rank + 1 == size ? n : n / size * (rank + 1);
  std::vector<PetscInt> begin;
  for (PetscInt i = first; i <= end; ++i) begin.push_back(A.row_begin[i] - A.row_begin[first]);
  const PetscInt* columns = A.columns.data() + A.row_begin[first];
  const PetscScalar* values = A.values.data() + A.row_begin[first];
  Mat mat = nullptr;
  ok(MatCreate(PETSC_COMM_WORLD, &mat));
  ok(MatSetSizes(mat, end - first, end - first, n, n));
  ok(MatSetType(mat, size > 1 ? MATMPISBAIJ : MATSEQSBAIJ));
  if (size > 1)
    ok(MatMPISBAIJSetPreallocationCSR(mat, 1, begin.data(), columns, values));
  else
    ok(MatSeqSBAIJSetPreallocationCSR(mat, 1, begin.data(), columns, values));
  ok(MatSetOption(mat, MAT_SPD, PETSC_TRUE));
  if (size > 1) return mat;
  std::vector<PetscInt> sizes;
  for (std::size_t g = 1; g < A.group_begin.size(); ++g)
    if (const PetscInt s = A.group_begin[g] - A.group_begin[g - 1]; s > 0) sizes.push_back(s);
  ok(MatSetVariableBlockSizes(mat, static_cast<PetscInt>(sizes.size()), sizes.data()));
  return mat;
}

double norm(Mat X) {
  PetscReal value = 0.0;
  ok(MatNorm(X, NORM_FROBENIUS, &value));
  return value;
}

// R = B - A X.
void residual(Mat A, Mat B, Mat X, Mat R) {
  PetscInt n_cols = 0;
  ok(MatGetSize(B, nullptr, &n_cols));
  ok(MatCopy(B, R, SAME_NONZERO_PATTERN));
  Vec product = nullptr;
  ok(MatCreateVecs(A, nullptr, &product));
  for (PetscInt c = 0; c < n_cols; ++c) {
    Vec x = nullptr, r = nullptr;
    ok(MatDenseGetColumnVecRead(X, c, &x));
    ok(MatMult(A, x, product));
    ok(MatDenseRestoreColumnVecRead(X, c, &x));
    ok(MatDenseGetColumnVec(R, c, &r));
    ok(VecAXPY(r, -1.0, product));
    ok(MatDenseRestoreColumnVec(R, c, &r));
  }
  ok(VecDestroy(&product));
}

// The least of some solves.
struct Best {
  double seconds = 1e300, processor = 1e300;
};
Best best_solve(Mat F, Mat B, Mat X) {
  constexpr int kTimes = 10;
  Best best;
  for (int time = 0; time < kTimes; ++time) {
    Spent once;
    ok(MatMatSolve(F, B, X));
    once.stop();
    best.seconds = std::min(best.seconds, once.seconds);
    best.processor = std::min(best.processor, once.processor_s);
  }
  return best;
}

void set_up_mumps(Mat F, const Configuration& how) {
  ok(MatMumpsSetIcntl(F, 7, 5));    // METIS where MUMPS has it; else its own choice
  ok(MatMumpsSetIcntl(F, 14, 40));  // per cent of memory beyond its estimate
  if (how.low_rank == 0.0) return;
  ok(MatMumpsSetIcntl(F, 35, 2));  // factorisation and solves
  ok(MatMumpsSetCntl(F, 7, how.low_rank));
}

// Entries of the factor that are stored.
double entries_of(Mat F, const Configuration& how) {
  if (std::string(how.package) != "mumps") {
    MatInfo info{};
    ok(MatGetInfo(F, MAT_GLOBAL_SUM, &info));
    return info.nz_used;
  }
  PetscInt entries = 0;
  ok(MatMumpsGetInfog(F, how.low_rank > 0.0 ? 35 : 29, &entries));
  return entries < 0 ? -1e6 * entries : entries;
}

void solve(const std::string& name, const std::filesystem::path& file, const Configuration& how) {
  constexpr PetscInt kColumns = 16;
  const linalg::Session session;
  Mat A = create(read_matrix(file)), F = nullptr, B = nullptr, X = nullptr, R = nullptr, D = nullptr;
  PetscInt n = 0, n_own = 0;
  ok(MatGetSize(A, &n, nullptr));
  ok(MatGetLocalSize(A, &n_own, nullptr));
  std::ofstream("/proc/self/clear_refs") << "5";  // the peak of memory begins here
  const double before = memory("VmRSS:");
  MatFactorInfo info;
  ok(MatFactorInfoInitialize(&info));
  Spent analysis;
  ok(MatGetFactor(A, how.package, MAT_FACTOR_CHOLESKY, &F));
  const bool mumps = std::string(how.package) == "mumps";
  if (mumps) set_up_mumps(F, how);
  if (how.single) ok(PetscOptionsSetValue(nullptr, "-mat_fronts_precision", "single"));
  ok(MatCholeskyFactorSymbolic(F, A, nullptr, &info));
  analysis.stop();
  Spent numeric;
  ok(MatCholeskyFactorNumeric(F, A, &info));
  numeric.stop();
  MatFactorError error = MAT_FACTOR_NOERROR;
  ok(MatFactorGetError(F, &error));
  if (error != MAT_FACTOR_NOERROR) throw std::runtime_error("the factorisation failed");
  ok(MatCreateDense(PETSC_COMM_WORLD, n_own, PETSC_DECIDE, n, kColumns, nullptr, &B));
  PetscScalar* values = nullptr;
  ok(MatDenseGetArray(B, &values));
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (PetscInt k = 0; k < n_own * kColumns; ++k) values[k] = normal(random);
  ok(MatDenseRestoreArray(B, &values));
  for (Mat* mat : {&X, &R, &D}) ok(MatDuplicate(B, MAT_COPY_VALUES, mat));
  const Best of_16 = best_solve(F, B, X);
  Mat half_B = nullptr, half_X = nullptr;
  ok(MatDenseGetSubMatrix(B, PETSC_DECIDE, PETSC_DECIDE, 0, kColumns / 2, &half_B));
  ok(MatDenseGetSubMatrix(X, PETSC_DECIDE, PETSC_DECIDE, 0, kColumns / 2, &half_X));
  const Best of_8 = best_solve(F, half_B, half_X);
  ok(MatDenseRestoreSubMatrix(X, &half_X));
  ok(MatDenseRestoreSubMatrix(B, &half_B));
  const double peak = memory("VmHWM:") - before;
  residual(A, B, X, R);
  const double first = norm(R) / norm(B);
  ok(MatMatSolve(F, R, D));
  ok(MatAXPY(X, 1.0, D, SAME_NONZERO_PATTERN));
  residual(A, B, X, R);
  const double refined = norm(R) / norm(B);
  const double entries = entries_of(F, how);
  PetscInt ordering = 0;
  if (mumps) ok(MatMumpsGetInfog(F, 7, &ordering));
  const auto print = [&](const char* what, double value, const char* unit) {
    ok(PetscPrintf(PETSC_COMM_WORLD, "%s",
                   fmt::format("{}.{}.{} = {:.4g} {}\n", name, how.name, what, value, unit).c_str()));
  };
  print("analysis", analysis.seconds, "s");
  print("numeric", numeric.seconds, "s");
  print("numeric_processor", numeric.processor_s, "s");
  print("solve_16", of_16.seconds, "s");
  print("solve_16_processor", of_16.processor, "s");
  print("solve_8", of_8.seconds, "s");
  print("entries", 1e-6 * entries, "1e6");
  print("memory", 1e-9 * peak, "GB");
  print("residual", first, "1");
  print("residual_refined", refined, "1");
  if (mumps) print("ordering", ordering, "1");
  for (Mat* mat : {&F, &B, &X, &R, &D, &A}) ok(MatDestroy(mat));
}

// The figures of one package, by this program in a process (or two) of its own.
void compare(const std::string& self, const std::string& name, const std::filesystem::path& file) {
  const char* only = std::getenv("FLEXURA_PACKAGES");
  for (const Configuration& how : kConfigurations) {
    if (only && ("," + std::string(only) + ",").find("," + std::string(how.name) + ",") == std::string::npos)
      continue;
    const std::string launch =
        how.processes > 1 ? fmt::format("mpirun --allow-run-as-root --oversubscribe -n {} ", how.processes)
                          : "";
    const std::string command = fmt::format("OPENBLAS_NUM_THREADS={} {}'{}' --solve '{}' '{}' '{}'",
                                            how.blas_threads, launch, self, name, file.string(), how.name);
    if (std::system(command.c_str()) != 0) fmt::print(stderr, "{}.{}: no figures\n", name, how.name);
  }
}

int run(const std::vector<std::string>& words) {
  if (words.size() == 5 && words[1] == "--solve") {
    for (const Configuration& how : kConfigurations)
      if (words[4] == how.name) {
        solve(words[2], words[3], how);
        return 0;
      }
    throw std::runtime_error("no such configuration: " + words[4]);
  }
  if (words.size() < 3) {
    fmt::print(stderr,
               "usage: bench_solvers NAME slender|thin|shell-like, bench_solvers NAME PART.toml SIZE\n"
               "FLEXURA_PACKAGES=fronts,mumps: these only\n");
    return 2;
  }
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / fmt::format("flexura_bench_{}.bin", std::random_device{}());
  // A process of its own assembles: what MPI is in one process is not inherited by the next.
  if (words.size() > 3 && words[1] == "--assemble") {
    const linalg::Session session;
    write(words[2], stiffness_of(words[3], words.size() > 4 ? words[4] : ""));
    return 0;
  }
  const std::string command = fmt::format("'{}' --assemble '{}' '{}' {}", words[0], file.string(), words[2],
                                          words.size() > 3 ? "'" + words[3] + "'" : "");
  if (std::system(command.c_str()) != 0) throw std::runtime_error("the part cannot be assembled");
  fmt::print("{}.dofs = {} 1\n", words[1], read_matrix(file).size());
  std::fflush(stdout);
  compare(words[0], words[1], file);
  std::filesystem::remove(file);
  return 0;
}

}  // namespace
}  // namespace flexura::reduce

int main(int argc, char** argv) {
  try {
    return flexura::reduce::run({argv, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 1;
  }
}
