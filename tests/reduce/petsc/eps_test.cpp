// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <slepceps.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "reduce/linalg/eigen/block_lanczos.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"
#include "reduce/linalg/factor/cholesky.hpp"
#include "reduce/linalg/petsc/petsc_check.hpp"
#include "tests/app/command.hpp"
#include "tests/reduce/petsc/petsc_options.hpp"
#include "tests/reduce/unit_masses.hpp"

// The eigensolver type "blocklanczos" through SLEPc's own functions, and SLEPc's other types on the road of reductions.
namespace flexura::linalg {
namespace {

using testing::ok;
using testing::Options;

// S (A - shift 1) S and S^2 for the Laplacian A of an n x n grid (eigenvalues 4 - 2 cos(i h) - 2 cos(j h), h = pi / (n + 1),
// most of them double) and a diagonal S that spreads over two decades.
struct Grid {
  Mat K = nullptr, M = nullptr;
  std::vector<PetscInt> begin{0}, columns, begin_M{0}, columns_M;
  std::vector<PetscScalar> values, values_M;

  explicit Grid(int n, double shift = 0.0) {
    const auto scale = [&](int i) { return std::pow(10.0, 2.0 * (i * 7 % 11) / 10.0 - 1.0); };
    const PetscInt size = n * n;
    for (int i = 0; i < size; ++i) {
      const auto add = [&](int j, double value) {
        columns.push_back(j);
        values.push_back(scale(i) * value * scale(j));
      };
      add(i, 4.0 - shift);
      if (i % n + 1 < n) add(i + 1, -1.0);
      if (i + n < size) add(i + n, -1.0);
      begin.push_back(static_cast<PetscInt>(columns.size()));
      columns_M.push_back(i);
      values_M.push_back(scale(i) * scale(i));
      begin_M.push_back(i + 1);
    }
    ok(MatCreateSeqSBAIJWithArrays(PETSC_COMM_SELF, 1, size, size, begin.data(), columns.data(),
                                   values.data(), &K));
    ok(MatCreateSeqSBAIJWithArrays(PETSC_COMM_SELF, 1, size, size, begin_M.data(), columns_M.data(),
                                   values_M.data(), &M));
  }
  ~Grid() {
    MatDestroy(&K);
    MatDestroy(&M);
  }
  static std::vector<double> eigenvalues(int n) {
    std::vector<double> exact;
    const double h = std::numbers::pi / (n + 1);
    for (int i = 1; i <= n; ++i)
      for (int j = 1; j <= n; ++j) exact.push_back(4.0 - 2.0 * std::cos(i * h) - 2.0 * std::cos(j * h));
    std::sort(exact.begin(), exact.end());
    return exact;
  }
};

struct Eps {
  EPS eps = nullptr;
  Eps(Mat K, Mat M, int count, double sigma) {
    ST st = nullptr;
    KSP ksp = nullptr;
    PC pc = nullptr;
    ok(EPSCreate(PETSC_COMM_SELF, &eps));
    ok(EPSSetOperators(eps, K, M));
    ok(EPSSetProblemType(eps, M ? EPS_GHEP : EPS_HEP));
    ok(EPSSetType(eps, "blocklanczos"));
    ok(EPSSetDimensions(eps, count, PETSC_DEFAULT, PETSC_DEFAULT));
    ok(EPSSetTolerances(eps, 1e-11, PETSC_DEFAULT));
    ok(EPSSetTarget(eps, sigma));
    ok(EPSGetST(eps, &st));
    ok(STSetType(st, STSINVERT));
    ok(STGetKSP(st, &ksp));
    ok(KSPSetType(ksp, KSPPREONLY));
    ok(KSPGetPC(ksp, &pc));
    ok(PCSetType(pc, PCCHOLESKY));
    ok(PCFactorSetMatSolverType(pc, "fronts"));
    ok(EPSSetFromOptions(eps));
  }
  ~Eps() { EPSDestroy(&eps); }
  // Solves; relative residuals and errors of eigenvalues are at round-off, vectors M-orthonormal.
  int expect(const std::vector<double>& exact, double offset) {
    ok(EPSSolve(eps));
    PetscInt n = 0;
    ok(EPSGetConverged(eps, &n));
    for (PetscInt k = 0; k < n; ++k) {
      PetscScalar value = 0.0;
      PetscReal error = 1.0;
      ok(EPSGetEigenvalue(eps, k, &value, nullptr));
      // Eigenvalues are accurate to the square of the residual, so to round-off: some ulps of the largest one (8).
      EXPECT_NEAR(value, exact[k] - offset, 1e-13) << "pair " << k;
      ok(EPSComputeError(eps, k, EPS_ERROR_ABSOLUTE, &error));
      EXPECT_LT(error, 1e-7);
    }
    Mat gram = nullptr;
    BV basis = nullptr;
    ok(EPSGetBV(eps, &basis));
    ok(BVSetActiveColumns(basis, 0, n));
    ok(MatCreateSeqDense(PETSC_COMM_SELF, n, n, nullptr, &gram));
    ok(BVDot(basis, basis, gram));
    ok(MatShift(gram, -1.0));
    PetscReal norm = 1.0;
    ok(MatNorm(gram, NORM_FROBENIUS, &norm));
    EXPECT_LT(norm, 1e-11);
    ok(MatDestroy(&gram));
    return n;
  }
};

TEST(BlockLanczosType, FindsDoubleEigenvaluesOfTheGeneralisedProblem) {
  const Grid grid(30);
  Eps eps(grid.K, grid.M, 40, 0.0);
  EXPECT_GE(eps.expect(Grid::eigenvalues(30), 0.0), 40);
}

TEST(BlockLanczosType, FindsThoseOfTheStandardProblem) {
  const Grid grid(12);
  Mat A = nullptr;
  ok(MatDuplicate(grid.K, MAT_COPY_VALUES, &A));
  Vec root = nullptr, unused = nullptr;
  ok(MatCreateVecs(A, &root, &unused));
  ok(MatGetDiagonal(grid.M, root));
  ok(VecSqrtAbs(root));
  ok(VecReciprocal(root));
  ok(MatDiagonalScale(A, root, root));
  Eps eps(A, nullptr, 9, 0.0);
  // Eigenvalues 10 and 11 (from 1) are twins, 9 stands beside 8 or 10.
  EXPECT_GE(eps.expect(Grid::eigenvalues(12), 0.0), 9);
  ok(VecDestroy(&root));
  ok(VecDestroy(&unused));
  ok(MatDestroy(&A));
}

TEST(BlockLanczosType, KeepsAClusterAtTheCutWhole) {
  const Grid grid(12);
  // Eigenvalue 2 (from 0) is the twin of eigenvalue 1.
  Eps eps(grid.K, grid.M, 2, 0.0);
  EXPECT_EQ(eps.expect(Grid::eigenvalues(12), 0.0), 3);
}

TEST(BlockLanczosType, WorksWithAShiftBelowAnIndefiniteMatrix) {
  const Grid grid(20, 0.5);
  Eps eps(grid.K, grid.M, 12, -1.0);
  EXPECT_GE(eps.expect(Grid::eigenvalues(20), 0.5), 12);
}

// Eigenvalue 4 is fourfold, blocks of three meet three of its vectors.
TEST(BlockLanczosType, FindsEverythingInASmallSpaceAndWithSmallBlocks) {
  const Options options("-eps_blocklanczos_block", "3");
  const Grid grid(4);
  Eps eps(grid.K, grid.M, 16, 0.0);
  EXPECT_EQ(eps.expect(Grid::eigenvalues(4), 0.0), 16);
}

// The least basis that is chosen where memory is short: eigenvalues up to eightfold, thick restarts.
TEST(BlockLanczosType, RestartsWithinTheLeastBasis) {
  EXPECT_EQ(block_lanczos_vectors(150), 4 * 150 + 17 * 16);
  EXPECT_EQ(block_lanczos_vectors(150, 16, 300.5), 300);
  const int least = block_lanczos_vectors(150, 16, 0.0);
  EXPECT_EQ(least, 200 + 64);
  EXPECT_LT(block_lanczos_vectors(1, 16, 0.0), 100);
  const std::string vectors = std::to_string(least);
  const Options options("-eps_ncv", vectors.c_str());
  const Grid grid(40);
  Eps eps(grid.K, grid.M, 150, 0.0);
  EXPECT_GE(eps.expect(Grid::eigenvalues(40), 0.0), 150);
}

// A basis that is too small for the Krylov space makes thick restarts.
TEST(BlockLanczosType, RestartsWithinASmallBasis) {
  const Options options({{"-eps_ncv", "120"}, {"-eps_blocklanczos_block", "8"}});
  const Grid grid(40);
  Eps eps(grid.K, grid.M, 60, 0.0);
  EXPECT_GE(eps.expect(Grid::eigenvalues(40), 0.0), 60);
}

void expect_refusal(Eps& eps, const char* text) {
  try {
    ok(EPSSolve(eps.eps));
    FAIL() << "nothing was thrown; expected: " << text;
  } catch (const std::exception& thrown) {
    EXPECT_THAT(thrown.what(), ::testing::HasSubstr(text));
    EXPECT_THAT(thrown.what(), ::testing::Not(::testing::HasSubstr("\n")));
  }
}

TEST(BlockLanczosType, WhatItDoesNotFindIsRefused) {
  const Grid grid(12);
  {
    Eps eps(grid.K, grid.M, 4, 1.0);
    expect_refusal(eps, "eigenvalues below the shift");
  }
  {
    Eps eps(grid.K, grid.M, 4, 0.0);
    ok(EPSSetWhichEigenpairs(eps.eps, EPS_LARGEST_REAL));
    expect_refusal(eps, "lowest eigenvalues");
  }
  {
    const Options options("-st_type", "shift");
    Eps eps(grid.K, grid.M, 4, 0.0);
    expect_refusal(eps, "shift-and-invert");
  }
  {
    const Options options("-eps_blocklanczos_slice", "20");
    Eps eps(grid.K, grid.M, 4, 0.0);
    expect_refusal(eps, "-eps_blocklanczos_slice: slices are for reductions");
  }
  {
    // K itself is singular to round-off there.
    const double exact = Grid::eigenvalues(12)[0];
    Eps eps(grid.K, grid.M, 4, exact);
    expect_refusal(eps, "");
  }
}

// The road of reductions: operators by functions, the type by option.
class Types : public ::testing::TestWithParam<std::string> {};

TEST_P(Types, GiveTheSameEigenpairs) {
  const Options options({{"-eps_type", GetParam()}});
  const int n = 14;
  std::vector<int> begin{0}, columns;
  for (int i = 0; i < n * n; ++i) {
    columns.push_back(i);
    if (i % n + 1 < n) columns.push_back(i + 1);
    if (i + n < n * n) columns.push_back(i + n);
    begin.push_back(static_cast<int>(columns.size()));
  }
  SymmetricMatrix A(begin, columns);
  for (int i = 0; i < n * n; ++i) {
    A.add_to_diagonal(i, 4.0);
    if (i % n + 1 < n) A.add_to_entry(i, i + 1, -1.0);
    if (i + n < n * n) A.add_to_entry(i, i + n, -1.0);
  }
  A.finish();
  const CholeskyFactor factor(A);
  const EigenProblem problem = testing::unit_mass_problem(A, factor);
  const std::vector<double> exact = Grid::eigenvalues(n);
  // Five and six are twins, seven and eight too: the cut between them keeps both.
  const EigenPairs pairs = block_lanczos(problem, {6, 0.0, 1e-9});
  ASSERT_GE(pairs.omega2.size(), 6);
  for (Eigen::Index k = 0; k < pairs.omega2.size(); ++k)
    EXPECT_NEAR(pairs.omega2(k), exact[k], 1e-13) << "pair " << k;
  EXPECT_LT(pairs.residual.maxCoeff(), 1e-9);
  EXPECT_LT(
      (pairs.Phi.transpose() * pairs.Phi - Eigen::MatrixXd::Identity(pairs.Phi.cols(), pairs.Phi.cols()))
          .norm(),
      1e-12);
  EXPECT_NEAR(pairs.omega2_next, exact[pairs.omega2.size()], 1e-6);
  // Methods on single vectors may miss twins: that is what the certificate of reductions is for.
  if (GetParam() == "krylovschur" || GetParam() == "arnoldi") return;
  int below = 20;
  while (exact[below] - exact[below - 1] < 1e-2) ++below;
  EXPECT_EQ(block_lanczos(problem, {1, 0.5 * (exact[below - 1] + exact[below]), 1e-9}).omega2.size(), below);
}

// Thirty equal chains of twelve springs that nothing joins, as equal bays between stiff bulkheads are: every eigenvalue is
// thirtyfold, blocks have eight vectors.
TEST(BlockLanczosType, FindsClustersThatAreLargerThanItsBlocks) {
  constexpr int kChains = 30, kLength = 12;
  std::vector<int> begin{0}, columns;
  for (int i = 0; i < kChains * kLength; ++i) {
    columns.push_back(i);
    if (i % kLength + 1 < kLength) columns.push_back(i + 1);
    begin.push_back(static_cast<int>(columns.size()));
  }
  SymmetricMatrix A(begin, columns);
  for (int i = 0; i < kChains * kLength; ++i) {
    A.add_to_diagonal(i, 2.0);
    if (i % kLength + 1 < kLength) A.add_to_entry(i, i + 1, -1.0);
  }
  A.finish();
  const CholeskyFactor factor(A);
  const EigenProblem problem = testing::unit_mass_problem(A, factor);
  for (const int count : {1, 3, 20, 31, 80}) {
    const EigenPairs pairs = block_lanczos(problem, {count, 0.0, 1e-9});
    ASSERT_EQ(pairs.omega2.size(), (count + kChains - 1) / kChains * kChains) << count;
    for (Eigen::Index k = 0; k < pairs.omega2.size(); ++k)
      EXPECT_NEAR(
          pairs.omega2(k),
          2.0 - 2.0 * std::cos(static_cast<double>(k / kChains + 1) * std::numbers::pi / (kLength + 1)),
          1e-13)
          << "pair " << k << " of " << count;
    EXPECT_LT(pairs.residual.maxCoeff(), 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Types,
                         ::testing::Values("blocklanczos", "krylovschur", "arnoldi", "subspace", "lobpcg",
                                           "gd", "jd"),
                         [](const auto& info) { return info.param; });

// The vectors' rows lie on two processes, the factor is MUMPS' over both.
TEST(BlockLanczosType, ProcessesShareTheVectors) {
  const test::Outcome outcome =
      test::run("/usr/bin/env",
                {"-i", "PATH=/usr/bin:/bin", "HOME=/tmp", "OPENBLAS_NUM_THREADS=1",
                 "ASAN_OPTIONS=detect_leaks=0", "/usr/bin/mpirun", "--allow-run-as-root", "--oversubscribe",
                 "-n", "2", std::string(FLEXURA_BIN_DIR) + "/../tests/bin/petsc_processes"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, ::testing::HasSubstr("2 processes, 24 of 24 eigenvalues are exact"));
}

}  // namespace
}  // namespace flexura::linalg
