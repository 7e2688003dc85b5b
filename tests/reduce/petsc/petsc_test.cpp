// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <petscksp.h>

#include <Eigen/Dense>
#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "reduce/linalg/factor/mumps_workspace.hpp"
#include "tests/reduce/petsc/petsc_options.hpp"

// The solver package "fronts" through PETSc's own functions, beside CHOLMOD and MUMPS.
namespace flexura::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

using testing::ok;
using testing::Options;

// A graph of `n` nodes of three rows each, some 8 neighbours a node: strictly diagonally dominant by
// `dominance`, less `shift`, rows scaled over four decades.
MatrixXd random_symmetric(int n_nodes, double shift, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  std::uniform_int_distribution<int> node(0, n_nodes - 1);
  const int n = 3 * n_nodes;
  MatrixXd A = MatrixXd::Zero(n, n);
  const auto couple = [&](int p, int q) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) A(3 * p + i, 3 * q + j) = number(random);
  };
  for (int p = 0; p < n_nodes; ++p) {
    couple(p, p);
    if (p > 0) couple(p, p - 1);
    for (int k = 0; k < 3; ++k)
      if (const int q = node(random); q != p) couple(p, q);
  }
  A = (A + A.transpose()).eval();
  A.diagonal() = A.cwiseAbs().rowwise().sum() - A.diagonal().cwiseAbs();
  A.diagonal().array() += 0.1;
  VectorXd scale(n);
  for (double& s : scale) s = std::pow(10.0, number(random));
  A = scale.asDiagonal() * A * scale.asDiagonal();
  A.diagonal() -= shift * scale.cwiseAbs2();
  return A;
}

class PetscMatrix {
 public:
  // The upper triangle; every diagonal entry is stored.
  PetscMatrix(const MatrixXd& A, bool definite) {
    begin_ = {0};
    for (int i = 0; i < A.rows(); ++i) {
      for (int j = i; j < A.cols(); ++j)
        if (i == j || A(i, j) != 0.0) {
          columns_.push_back(j);
          values_.push_back(A(i, j));
        }
      begin_.push_back(static_cast<PetscInt>(columns_.size()));
    }
    const auto n = static_cast<PetscInt>(A.rows());
    ok(MatCreateSeqSBAIJWithArrays(PETSC_COMM_SELF, 1, n, n, begin_.data(), columns_.data(), values_.data(),
                                   &mat_));
    ok(MatSetOption(mat_, MAT_SPD, definite ? PETSC_TRUE : PETSC_FALSE));
  }
  ~PetscMatrix() { MatDestroy(&mat_); }
  PetscMatrix(const PetscMatrix&) = delete;
  PetscMatrix& operator=(const PetscMatrix&) = delete;
  Mat get() const { return mat_; }

 private:
  std::vector<PetscInt> begin_, columns_;
  std::vector<PetscScalar> values_;
  Mat mat_ = nullptr;
};

struct Solver {
  KSP ksp = nullptr;
  explicit Solver(Mat A) {
    ok(KSPCreate(PETSC_COMM_SELF, &ksp));
    ok(KSPSetOperators(ksp, A, A));
    ok(KSPSetType(ksp, KSPPREONLY));
    PC pc = nullptr;
    ok(KSPGetPC(ksp, &pc));
    ok(PCSetType(pc, PCCHOLESKY));
    ok(KSPSetFromOptions(ksp));
  }
  ~Solver() { KSPDestroy(&ksp); }
  Mat factor() const {
    PC pc = nullptr;
    Mat F = nullptr;
    ok(KSPGetPC(ksp, &pc));
    ok(PCFactorGetMatrix(pc, &F));
    return F;
  }
  // Columns of `B`, one by one or together; `gap` rows lie between the columns of X.
  MatrixXd solve(const MatrixXd& B, bool together, int gap = 0) const {
    const auto n = static_cast<PetscInt>(B.rows()), k = static_cast<PetscInt>(B.cols());
    MatrixXd in = B, out = MatrixXd::Constant(n + gap, k, 7.0);
    if (together) {
      Mat b = nullptr, x = nullptr;
      ok(MatCreateSeqDense(PETSC_COMM_SELF, n, k, in.data(), &b));
      ok(MatCreateSeqDense(PETSC_COMM_SELF, n, k, out.data(), &x));
      ok(MatDenseSetLDA(x, n + gap));
      ok(KSPMatSolve(ksp, b, x));
      ok(MatDestroy(&b));
      ok(MatDestroy(&x));
    } else {
      for (PetscInt c = 0; c < k; ++c) {
        Vec b = nullptr, x = nullptr;
        ok(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, in.col(c).data(), &b));
        ok(VecCreateSeqWithArray(PETSC_COMM_SELF, 1, n, out.col(c).data(), &x));
        ok(KSPSolve(ksp, b, x));
        ok(VecDestroy(&b));
        ok(VecDestroy(&x));
      }
    }
    EXPECT_TRUE((out.bottomRows(gap).array() == 7.0).all()) << "written beyond the columns";
    return out.topRows(n);
  }
};

MatrixXd right_hand_sides(Eigen::Index n, int k) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  MatrixXd B(n, k);
  for (double& b : B.reshaped()) b = number(random);
  return B;
}

// Errors of a backward stable solve: condition number times ulps times the growth in the factors.
double tolerance(const MatrixXd& A) {
  const VectorXd values = A.selfadjointView<Eigen::Upper>().eigenvalues().cwiseAbs();
  return 1e-15 * 100.0 * values.maxCoeff() / values.minCoeff();
}

class Packages : public ::testing::TestWithParam<std::string> {};

TEST_P(Packages, SolveADefiniteMatrixByColumnsAndByBlocks) {
  const Options options({{"-pc_factor_mat_solver_type", GetParam()}});
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const MatrixXd A = random_symmetric(30 * static_cast<int>(seed), 0.0, seed);
    const PetscMatrix matrix(A, true);
    const Solver solver(matrix.get());
    const MatrixXd B = right_hand_sides(A.rows(), 13), exact = A.ldlt().solve(B);
    const double limit = tolerance(A) * exact.norm();
    EXPECT_LT((solver.solve(B, true) - exact).norm(), limit);
    EXPECT_LT((solver.solve(B, false) - exact).norm(), limit);
    for (const int k : {1, 2, 8})
      EXPECT_LT((solver.solve(B.leftCols(k), true) - exact.leftCols(k)).norm(), limit) << k << " columns";
    MatSolverType type = nullptr;
    ok(MatFactorGetSolverType(solver.factor(), &type));
    EXPECT_EQ(type, GetParam());
  }
}
INSTANTIATE_TEST_SUITE_P(All, Packages, ::testing::Values("fronts", "cholmod", "mumps"),
                         [](const auto& info) { return info.param; });

class PackagesWithInertia : public ::testing::TestWithParam<std::string> {};

TEST_P(PackagesWithInertia, SolveAnIndefiniteMatrixAndCountItsNegativeEigenvalues) {
  const Options options({{"-pc_factor_mat_solver_type", GetParam()}, {"-mat_mumps_icntl_24", "1"}});
  int most = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const MatrixXd A = random_symmetric(60, 1.5 * seed, seed);
    const VectorXd values = A.selfadjointView<Eigen::Upper>().eigenvalues();
    const PetscMatrix matrix(A, false);
    const Solver solver(matrix.get());
    const MatrixXd B = right_hand_sides(A.rows(), 5), exact = A.fullPivLu().solve(B);
    const double limit = tolerance(A) * exact.norm();
    EXPECT_LT((solver.solve(B, true) - exact).norm(), limit) << "seed " << seed;
    EXPECT_LT((solver.solve(B, false) - exact).norm(), limit) << "seed " << seed;
    PetscInt negative = 0, zero = 0, positive = 0;
    ok(MatGetInertia(solver.factor(), &negative, &zero, &positive));
    EXPECT_EQ(negative, (values.array() < 0.0).count()) << "seed " << seed;
    EXPECT_EQ(zero, 0);
    EXPECT_EQ(positive, (values.array() > 0.0).count());
    most = std::max(most, static_cast<int>(negative));
  }
  EXPECT_GT(most, 5);  // the matrices were indefinite
}
INSTANTIATE_TEST_SUITE_P(All, PackagesWithInertia, ::testing::Values("fronts", "mumps"),
                         [](const auto& info) { return info.param; });

const std::vector<std::pair<std::string, std::string>> kFrontsOption{
    {"-pc_factor_mat_solver_type", "fronts"}};

TEST(Fronts, NewNumbersInTheSamePatternAreFactorisedAnew) {
  const Options options(kFrontsOption);
  const MatrixXd A = random_symmetric(70, 0.0, 3), B = right_hand_sides(A.rows(), 4);
  const PetscMatrix matrix(A, true);
  const Solver solver(matrix.get());
  EXPECT_EQ(solver.solve(B, true, 3), solver.solve(B, true));
  ok(MatScale(matrix.get(), 4.0));
  EXPECT_LT((4.0 * solver.solve(B, true) - A.ldlt().solve(B)).norm(),
            tolerance(A) * A.ldlt().solve(B).norm());
}

TEST(Fronts, TakesPetscsOrderingsAndAnother) {
  const MatrixXd A = random_symmetric(70, 0.0, 3), B = right_hand_sides(A.rows(), 4),
                 exact = A.ldlt().solve(B);
  for (const char* ordering : {"natural", "rcm", "external"}) {
    const Options options({kFrontsOption.front(), {"-pc_factor_mat_ordering_type", ordering}});
    const PetscMatrix matrix(A, true);
    const Solver solver(matrix.get());
    EXPECT_LT((solver.solve(B, true) - exact).norm(), tolerance(A) * exact.norm()) << ordering;
  }
}

TEST(Fronts, AFactorInAFileIsTheSameToTheBit) {
  const MatrixXd A = random_symmetric(70, 0.0, 3), B = right_hand_sides(A.rows(), 9);
  const PetscMatrix matrix(A, true);
  const auto solution = [&](const char* place) {
    const Options options({kFrontsOption.front(), {"-mat_fronts_storage", place}});
    return Solver(matrix.get()).solve(B, true);
  };
  EXPECT_EQ(solution("file"), solution("memory"));
  EXPECT_THROW(solution("somewhere"), std::invalid_argument);
}

TEST(Fronts, SinglePrecisionIsRefinedByColumnsAndByBlocks) {
  const MatrixXd A = random_symmetric(70, 0.0, 3), B = right_hand_sides(A.rows(), 9),
                 exact = A.ldlt().solve(B);
  const PetscMatrix matrix(A, true);
  const auto factor_bytes = [&](const char* precision) {
    const Options options({kFrontsOption.front(), {"-mat_fronts_precision", precision}});
    const Solver solver(matrix.get());
    for (const bool together : {true, false})
      EXPECT_LT((solver.solve(B, together) - exact).norm(), tolerance(A) * exact.norm()) << precision;
    MatInfo info{};
    ok(MatGetInfo(solver.factor(), MAT_LOCAL, &info));
    return info.memory;
  };
  EXPECT_EQ(2.0 * factor_bytes("single"), factor_bytes("double"));
  const Options options({kFrontsOption.front(), {"-mat_fronts_precision", "half"}});
  try {
    Solver(matrix.get()).solve(B, true);
    FAIL() << "nothing was thrown";
  } catch (const std::invalid_argument& thrown) {
    EXPECT_STREQ(thrown.what(), "-mat_fronts_precision half: is double or single");
  }
}

TEST(Fronts, ASingularMatrixIsAZeroPivotWithItsRow) {
  const Options options(kFrontsOption);
  // Springs from node to node of a chain, held at neither end: what is left at the last pivot is round-off.
  const int n = 40;
  MatrixXd A = MatrixXd::Zero(n, n);
  for (int i = 0; i + 1 < n; ++i) {
    const double k = 1.0 / (3.0 + i);
    A(i, i) += k;
    A(i + 1, i + 1) += k;
    A(i, i + 1) = A(i + 1, i) = -k;
  }
  for (const bool definite : {true, false}) {
    const PetscMatrix matrix(A, definite);
    const Solver solver(matrix.get());
    ok(KSPSetUp(solver.ksp));
    MatFactorError error = MAT_FACTOR_NOERROR;
    PetscReal pivot = 1.0;
    PetscInt row = -1;
    ok(MatFactorGetError(solver.factor(), &error));
    EXPECT_EQ(error, MAT_FACTOR_NUMERIC_ZEROPIVOT);
    ok(MatFactorGetErrorZeroPivot(solver.factor(), &pivot, &row));
    EXPECT_LT(pivot, 1e-13);
    EXPECT_GE(row, 0);
    EXPECT_LT(row, n);
    KSPConvergedReason reason = KSP_CONVERGED_ITS;
    ok(KSPGetConvergedReason(solver.ksp, &reason));
    EXPECT_EQ(reason, KSP_DIVERGED_PC_FAILED);
  }
  // A definite one that is not.
  A(7, 7) = -1.0;
  const PetscMatrix matrix(A, true);
  const Solver solver(matrix.get());
  ok(KSPSetErrorIfNotConverged(solver.ksp, PETSC_TRUE));
  try {
    ok(KSPSetUp(solver.ksp));
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& thrown) {
    EXPECT_THAT(thrown.what(), ::testing::HasSubstr("singular"));
  }
}

void expect_refusal(Mat A, const char* text) {
  try {
    const Solver solver(A);
    ok(KSPSetUp(solver.ksp));
    FAIL() << "nothing was thrown; expected: " << text;
  } catch (const std::runtime_error& thrown) {
    EXPECT_THAT(thrown.what(), ::testing::HasSubstr(text));
    EXPECT_THAT(thrown.what(), ::testing::Not(::testing::HasSubstr("\n")));
  }
}

TEST(Mumps, AWorkspaceGivesBackAllButWhatIsKept) {
  MumpsWorkspace workspace;
  constexpr std::size_t kNumbers = 100000, kKept = 30000,
                        kPage = 65536 / sizeof(double);  // the largest there is
  double* const numbers = workspace.reserve(kNumbers);
  ASSERT_NE(numbers, nullptr);
  std::fill_n(numbers, kNumbers, 1.0);
  workspace.keep(kKept);
  EXPECT_EQ(std::count(numbers, numbers + kKept, 1.0), static_cast<std::ptrdiff_t>(kKept));
  // Memory that has been given back and comes again is zero.
  EXPECT_EQ(std::count(numbers + kKept + kPage, numbers + kNumbers, 0.0),
            static_cast<std::ptrdiff_t>(kNumbers - kKept - kPage));
}

// PETSc's call reaches the workspace, and no more is kept than the factor: its entries, and what MUMPS stores beside them of
// the triangles on the diagonal (none below 2/3 of the whole here).
TEST(Mumps, FactorisesInAWorkspaceThatIsLent) {
  const Options options({{"-pc_factor_mat_solver_type", "mumps"}});
  const MatrixXd A = random_symmetric(200, 0.0, 9);
  const PetscMatrix matrix(A, true);
  MumpsWorkspace workspace;
  const Solver solver(matrix.get());
  {
    const MumpsWorkspace::Lent lent(workspace);
    ok(KSPSetUp(solver.ksp));
  }
  PetscInt entries = 0;
  ok(MatMumpsGetInfog(solver.factor(), 29, &entries));
  EXPECT_GE(workspace.kept(), static_cast<std::size_t>(entries));
  EXPECT_LE(workspace.kept(), static_cast<std::size_t>(1.5 * entries));
  const MatrixXd B = right_hand_sides(A.rows(), 3), exact = A.ldlt().solve(B);
  EXPECT_LT((solver.solve(B, true) - exact).norm(), tolerance(A) * exact.norm());
}

TEST(Fronts, MatricesThatItDoesNotTakeAreNamed) {
  const Options options(kFrontsOption);
  std::vector<PetscInt> begin{0, 2, 2, 3}, columns{0, 1, 2};
  std::vector<PetscScalar> values{2.0, -1.0, 1.0};
  Mat A = nullptr;
  ok(MatCreateSeqSBAIJWithArrays(PETSC_COMM_SELF, 1, 3, 3, begin.data(), columns.data(), values.data(), &A));
  expect_refusal(A, "row 1 of the matrix has no diagonal entry");
  ok(MatDestroy(&A));
  ok(MatCreateSeqSBAIJ(PETSC_COMM_SELF, 2, 4, 4, 1, nullptr, &A));
  const PetscInt rows[] = {0, 1};
  const PetscScalar blocks[] = {2.0, 1.0, 1.0, 2.0};
  ok(MatSetValuesBlocked(A, 1, rows, 1, rows, blocks, INSERT_VALUES));
  ok(MatSetValuesBlocked(A, 1, rows + 1, 1, rows + 1, blocks, INSERT_VALUES));
  ok(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  ok(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  expect_refusal(A, "blocks of 2 x 2");
  ok(MatDestroy(&A));
  ok(MatCreateSeqAIJ(PETSC_COMM_SELF, 3, 3, 1, nullptr, &A));
  for (PetscInt i = 0; i < 3; ++i) ok(MatSetValue(A, i, i, 1.0, INSERT_VALUES));
  ok(MatAssemblyBegin(A, MAT_FINAL_ASSEMBLY));
  ok(MatAssemblyEnd(A, MAT_FINAL_ASSEMBLY));
  expect_refusal(A, "fronts");
  ok(MatDestroy(&A));
}

}  // namespace
}  // namespace flexura::linalg
