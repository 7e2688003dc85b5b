// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <numbers>

#include "mbs/base/threads/pool.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"
#include "reduce/linalg/factor/cholesky.hpp"
#include "reduce/linalg/factor/inertia.hpp"
#include "reduce/linalg/factor/supernodal_factor.hpp"
#include "tests/reduce/parts.hpp"
#include "tests/reduce/unit_masses.hpp"

namespace flexura::linalg {
namespace {

using reduce::testing::dense;
using reduce::testing::random_matrix;

// The Laplacian of an n x n grid: tridiagonal in both directions, eigenvalues 4 - 2 cos(i h) - 2 cos(j h),
// h = pi / (n + 1), most of them double.
SymmetricMatrix grid_laplacian(int n) {
  std::vector<int> begin{0}, columns;
  for (int i = 0; i < n * n; ++i) {
    columns.push_back(i);
    if (i % n + 1 < n) columns.push_back(i + 1);
    if (i + n < n * n) columns.push_back(i + n);
    begin.push_back(static_cast<int>(columns.size()));
  }
  SymmetricMatrix A(begin, columns);
  Eigen::MatrixXd link(2, 2);
  link << 0, -1, -1, 0;
  for (int i = 0; i < n * n; ++i) {
    A.add(std::vector<int>{i}, Eigen::MatrixXd::Constant(1, 1, 4.0));
    if (i % n + 1 < n) A.add(std::vector<int>{i, i + 1}, link);
    if (i + n < n * n) A.add(std::vector<int>{i, i + n}, link);
  }
  A.finish();
  return A;
}

std::vector<double> grid_eigenvalues(int n) {
  std::vector<double> values;
  const double h = std::numbers::pi / (n + 1);
  for (int i = 1; i <= n; ++i)
    for (int j = 1; j <= n; ++j) values.push_back(4.0 - 2.0 * std::cos(i * h) - 2.0 * std::cos(j * h));
  std::sort(values.begin(), values.end());
  return values;
}

TEST(SymmetricMatrix, ProductsAreThoseOfTheDenseMatrix) {
  const SymmetricMatrix A = grid_laplacian(7);
  const Eigen::MatrixXd D = dense(A);
  for (int k : {1, 3, 4, 9}) {
    const Eigen::MatrixXd X = random_matrix(49, k), X3 = random_matrix(147, k);
    Eigen::MatrixXd Y;
    A.multiply(X, Y);
    EXPECT_LT((Y - D * X).norm(), 1e-14 * Y.norm());
    A.multiply_magnitudes(X, Y);
    EXPECT_LT((Y - D.cwiseAbs() * X.cwiseAbs()).norm(), 1e-14 * Y.norm());
    A.multiply_kron3(X3, Y);
    EXPECT_LT((Y - reduce::testing::kron3(D) * X3).norm(), 1e-14 * Y.norm());
  }
}

TEST(SymmetricMatrix, AnEntryOutsideThePatternIsOneClearSentence) {
  SymmetricMatrix A({0, 1, 2}, {0, 1});
  for (const std::vector<int>& dofs : {std::vector<int>{0, 1}, {1, 2}, {2}}) try {
      A.add(dofs, Eigen::MatrixXd::Ones(2, 2));
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), ::testing::StrEq("adding to a matrix: the entry is outside its pattern"));
    }
}

// Dofs in any order, twice, left out.
TEST(SymmetricMatrix, BlocksAreAddedAsCtkCIs) {
  constexpr int n = 9;
  std::vector<int> begin{0}, columns;
  for (int i = 0; i < n; ++i) {
    for (int j = i; j < n; ++j) columns.push_back(j);
    begin.push_back(static_cast<int>(columns.size()));
  }
  SymmetricMatrix A(begin, columns);
  Eigen::MatrixXd exact = Eigen::MatrixXd::Zero(n, n);
  for (const std::vector<int>& dofs :
       {std::vector<int>{6, 7, 8, 0, 1, 2}, {4, -1, 2, 4, -3, 8}, {3, 3, 3, 5, 0, 5}}) {
    const Eigen::MatrixXd X = random_matrix(6, 6), block = X + X.transpose();
    Eigen::MatrixXd C = Eigen::MatrixXd::Zero(6, n);
    for (int a = 0; a < 6; ++a)
      if (dofs[a] >= 0) C(a, dofs[a]) = 1.0;
    exact += C.transpose() * block * C;
    A.add(dofs, block);
  }
  A.finish();
  EXPECT_LT((dense(A) - exact).norm(), 1e-14 * exact.norm());
}

TEST(Cholesky, SolvesManyRightHandSides) {
  const SymmetricMatrix A = grid_laplacian(40);
  const CholeskyFactor factor(A);
  const Eigen::MatrixXd B = random_matrix(1600, 13);
  Eigen::MatrixXd AX;
  A.multiply(factor.solve(B), AX);
  EXPECT_LT((AX - B).norm(), 1e-12 * B.norm());  // condition number about 700
}

TEST(Cholesky, SingularMatricesNameTheRow) {
  // A chain of springs in which the last link is missing: row 3 hangs free.
  SymmetricMatrix A({0, 2, 4, 6, 7}, {0, 1, 1, 2, 2, 3, 3});
  Eigen::MatrixXd link(2, 2);
  link << 1, -1, -1, 1;
  A.add(std::vector<int>{0, 1}, link);
  A.add(std::vector<int>{1, 2}, link);
  A.add(std::vector<int>{0}, Eigen::MatrixXd::Ones(1, 1));
  A.finish();
  try {
    const CholeskyFactor factor(A);
    FAIL() << "nothing was thrown";
  } catch (const SingularMatrix& singular) {
    EXPECT_EQ(singular.dof, 3);
  }
}

// A - sigma 1 of the grid, all in the diagonal.
SymmetricMatrix shifted_grid(int n, double sigma) {
  SymmetricMatrix A = grid_laplacian(n);
  for (int i = 0; i < n * n; ++i) A.add_to_entry(i, i, -sigma);
  return A;
}

// By Sylvester's law there are as many negative pivots as eigenvalues below sigma; 14,400 unknowns make
// subtrees for several cores and fronts above them.
TEST(Inertia, IsTheNumberOfTheGridsEigenvaluesBelowTheShift) {
  const int n = 120;
  const std::vector<double> exact = grid_eigenvalues(n);
  for (const double sigma : {-1.0, 0.5 * (exact[2] + exact[3]), 0.02, 0.1, 0.5}) {
    const SymmetricMatrix A = shifted_grid(n, sigma);
    const IndefiniteFactor factor(A);
    const auto below = std::lower_bound(exact.begin(), exact.end(), sigma) - exact.begin();
    EXPECT_EQ(factor.n_negative(), below) << "sigma " << sigma;
    // The eigenvalue nearest to sigma is 1e-5 away or more: condition number 1e6, times 1e-16, times growth.
    const Eigen::MatrixXd B = random_matrix(n * n, 11);
    Eigen::MatrixXd AX;
    A.multiply(factor.solve(B), AX);
    EXPECT_LT((AX - B).norm(), 1e-8 * B.norm()) << "sigma " << sigma;
  }
}

// The Laplacian of an n x n x n grid less sigma: eigenvalues 6 - 2 cos(i h) - 2 cos(j h) - 2 cos(k h) -
// sigma.
SymmetricMatrix shifted_cube(int n, double sigma) {
  std::vector<int> begin{0}, columns;
  const auto neighbours = [n](int i, const auto& visit) {
    if (i % n + 1 < n) visit(i + 1);
    if (i / n % n + 1 < n) visit(i + n);
    if (i / (n * n) + 1 < n) visit(i + n * n);
  };
  for (int i = 0; i < n * n * n; ++i) {
    columns.push_back(i);
    neighbours(i, [&](int j) { columns.push_back(j); });
    begin.push_back(static_cast<int>(columns.size()));
  }
  SymmetricMatrix A(begin, columns);
  for (int i = 0; i < n * n * n; ++i) {
    A.add_to_entry(i, i, 6.0 - sigma);
    neighbours(i, [&](int j) { A.add_to_entry(i, j, -1.0); });
  }
  A.finish();
  return A;
}

// Separators of a cube of 22 have 484 unknowns: fronts of several blocks of columns, with rows below them.
TEST(Inertia, FrontsOfSeveralBlocksCountTheEigenvaluesOfACube) {
  const int n = 22;
  ASSERT_GT(n * n, 2 * Trapezoid::kBlock);
  const double h = std::numbers::pi / (n + 1);
  std::vector<double> exact;
  for (int i = 1; i <= n; ++i)
    for (int j = 1; j <= n; ++j)
      for (int k = 1; k <= n; ++k)
        exact.push_back(6.0 - 2.0 * (std::cos(i * h) + std::cos(j * h) + std::cos(k * h)));
  std::sort(exact.begin(), exact.end());
  for (const double sigma : {0.0, 0.21, 0.5, 1.0}) {
    const SymmetricMatrix A = shifted_cube(n, sigma);
    const IndefiniteFactor factor(A);
    const auto above = std::lower_bound(exact.begin(), exact.end(), sigma);
    EXPECT_EQ(factor.n_negative(), above - exact.begin()) << "sigma " << sigma;
    const Eigen::MatrixXd B = random_matrix(n * n * n, 5);
    Eigen::MatrixXd AX;
    A.multiply(factor.solve(B), AX);
    // The nearest eigenvalue is farther than 1e-4, the largest 12: condition 1e5, times 1e-16, times growth.
    ASSERT_GT(*above - sigma, 1e-4);
    EXPECT_LT((AX - B).norm(), 1e-9 * B.norm()) << "sigma " << sigma;
  }
}

// The same operations in the same order, wherever the numbers are kept and however wide their indices are.
TEST(Cholesky, AFactorInAFileGivesTheSameNumbersToTheBit) {
  const SymmetricMatrix A = shifted_cube(22, 0.0);
  const Eigen::MatrixXd B = random_matrix(A.size(), 13);
  const CholeskyFactor in_memory(A, {}, {}, {.place = FactorStorage::Place::memory}),
      in_file(A, {}, {}, {.place = FactorStorage::Place::file});
  EXPECT_FALSE(in_memory.figures().in_file);
  EXPECT_TRUE(in_file.figures().in_file);
  EXPECT_EQ(in_file.solve(B), in_memory.solve(B));
  // As much beside it as no machine has: the file is chosen without being asked for.
  EXPECT_TRUE(CholeskyFactor(A, {}, {}, {.reserve = 1e18}).figures().in_file);
}

TEST(Cholesky, AFolderThatCannotHoldTheFactorIsNamed) {
  const SymmetricMatrix A = grid_laplacian(10);
  try {
    const CholeskyFactor factor(A, {}, {},
                                {.place = FactorStorage::Place::file, .folder = "/no/such/folder"});
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("/no/such/folder"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("TMPDIR"));
  }
}

TEST(SupernodalFactor, WideIndicesGiveTheSameFactor) {
  const SymmetricMatrix A = shifted_cube(12, 0.0);
  const std::vector<int> order = nested_dissection(A.csr());
  SupernodalFactor narrow(A.csr(), order), wide(A.csr(), order, SupernodalFactor::Indices::wide);
  EXPECT_EQ(wide.order(), narrow.order());
  EXPECT_EQ(wide.bytes(), narrow.bytes());
  ASSERT_EQ(narrow.factorise(A.csr(), true), -1);
  ASSERT_EQ(wide.factorise(A.csr(), true), -1);
  const Eigen::MatrixXd B = random_matrix(A.size(), 3);
  Eigen::MatrixXd X, Y;
  narrow.solve(B, X);
  wide.solve(B, Y);
  EXPECT_EQ(X, Y);
}

TEST(SymmetricMatrix, APanelOnTwoCoresIsThatOnOne) {
  const SymmetricMatrix A = shifted_cube(22, 0.7);
  const RowPanel X = random_matrix(3 * A.size(), 8);
  RowPanel one, two;
  const int before = threads::count();
  threads::set_count(2);
  A.multiply_kron3(X, one);
  A.multiply_kron3(X, two, true);
  threads::set_count(before);
  EXPECT_LT((two - one).norm(), 1e-15 * one.norm());  // seven terms in another order
}

// Subtrees, what is above them and panels of right-hand sides are cut otherwise for each number of cores and of columns.
TEST(SupernodalFactor, SolvesAnyNumberOfColumnsOnAnyNumberOfCores) {
  const SymmetricMatrix A = shifted_cube(22, 0.0);
  const std::vector<int> order = nested_dissection(A.csr());
  const int before = threads::count();
  for (const int n_cores : {1, 2, 7}) {
    threads::set_count(n_cores);
    SupernodalFactor L(A.csr(), order);
    ASSERT_EQ(L.factorise(A.csr(), true), -1);
    for (const int n_columns : {1, 3, 5, 8, 12, 16, 19}) {
      const Eigen::MatrixXd B = random_matrix(A.size(), n_columns);
      Eigen::MatrixXd X, AX;
      L.solve(B, X);
      A.multiply(X, AX);
      // A few hundred sums of round-off at most, the matrix' condition is 200.
      EXPECT_LT((AX - B).colwise().norm().maxCoeff(), 1e-12 * B.norm())
          << n_columns << " columns on " << n_cores << " cores";
    }
  }
  threads::set_count(before);
}

TEST(Inertia, ALimitOnAnEigenvalueIsRefused) {
  const std::vector<double> exact = grid_eigenvalues(30);
  EXPECT_THROW(IndefiniteFactor(shifted_grid(30, exact[5])), std::runtime_error);
}

TEST(Dense, TallProductsOfAnyShapeAreThoseOfTheirEntries) {
  for (const int rows : {5, 700, 9001})
    for (const int cols : {1, 6, 17})
      for (const int few : {1, 8, 13, 40}) {
        const Eigen::MatrixXd A = random_matrix(rows, cols), B = random_matrix(rows, few, 2),
                              S = random_matrix(cols, few, 3);
        // Entries up to 1: sums of `rows` products are right to that many ulps.
        EXPECT_LT((transpose_times(A, B) - A.transpose() * B).cwiseAbs().maxCoeff(), 2e-16 * rows);
        Eigen::MatrixXd C = B;
        add_product(-0.5, A, S, C);
        EXPECT_LT((C - (B - 0.5 * A * S)).cwiseAbs().maxCoeff(), 2e-16 * (cols + 2));
      }
}

// Numbers that are none are told, not taken for a lack of convergence.
TEST(Dense, AnEigenproblemThatHoldsNaNSaysSo) {
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(40, 40);
  A(7, 7) = std::numeric_limits<double>::quiet_NaN();
  for (const auto& solve : {+[](const Eigen::MatrixXd& X) { symmetric_eigen(X); },
                            +[](const Eigen::MatrixXd& X) {
                              generalized_eigen(X, Eigen::MatrixXd::Identity(X.rows(), X.cols()));
                            }})
    try {
      solve(A);
      FAIL() << "took it";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(),
                  ::testing::HasSubstr("a small eigenproblem of 40 rows holds NaN or infinity"));
    }
}

class Eigensolvers : public ::testing::TestWithParam<bool> {
 protected:
  EigenPairs solve(const EigenProblem& problem, const EigenRequest& request) const {
    return GetParam() ? block_lanczos(problem, request) : krylov_schur(problem, request);
  }
};

// Eigenvalues are accurate to the square of the residual, so to round-off: n times 1e-16 of the largest one
// (8).
TEST_P(Eigensolvers, FindDoubleEigenvaluesOfTheGrid) {
  const int n = 30;
  const SymmetricMatrix A = grid_laplacian(n);
  const CholeskyFactor factor(A);
  const EigenProblem problem = testing::unit_mass_problem(A, factor);
  const std::vector<double> exact = grid_eigenvalues(n);
  const EigenPairs pairs = solve(problem, {40, 0.0, 1e-9});
  ASSERT_GE(pairs.omega2.size(), 40);
  for (int k = 0; k < 40; ++k) EXPECT_NEAR(pairs.omega2(k), exact[k], 1e-13) << "pair " << k;
  EXPECT_LT(pairs.residual.maxCoeff(), 1e-9);
  const Eigen::MatrixXd gram = pairs.Phi.transpose() * pairs.Phi;
  EXPECT_LT((gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).norm(), 1e-10);
}

TEST_P(Eigensolvers, KeepAClusterAtTheCutWhole) {
  const SymmetricMatrix A = grid_laplacian(12);
  const CholeskyFactor factor(A);
  // Eigenvalue 2 (from 0) is the twin of eigenvalue 1.
  EXPECT_EQ(solve(testing::unit_mass_problem(A, factor), {2, 0.0, 1e-9}).omega2.size(), 3);
}

TEST_P(Eigensolvers, FindAllUpToALimit) {
  const int n = 30;
  const SymmetricMatrix A = grid_laplacian(n);
  const CholeskyFactor factor(A);
  const std::vector<double> exact = grid_eigenvalues(n);
  const double limit = 0.5 * (exact[99] + exact[100]);
  ASSERT_GT(exact[100] - exact[99], 1e-3);
  EXPECT_EQ(solve(testing::unit_mass_problem(A, factor), {1, limit, 1e-9}).omega2.size(), 100);
}

TEST_P(Eigensolvers, FindEverythingInASmallSpace) {
  const SymmetricMatrix A = grid_laplacian(4);
  const CholeskyFactor factor(A);
  const std::vector<double> exact = grid_eigenvalues(4);
  const EigenPairs pairs = solve(testing::unit_mass_problem(A, factor), {16, 0.0, 1e-9});
  ASSERT_EQ(pairs.omega2.size(), 16);
  for (int k = 0; k < 16; ++k) EXPECT_NEAR(pairs.omega2(k), exact[k], 1e-13);
}

TEST_P(Eigensolvers, WorkWithAShift) {
  // A - a 1 is indefinite; A = (A - a 1) + a 1 is factorised.
  const int n = 20;
  const SymmetricMatrix A = grid_laplacian(n);
  const CholeskyFactor factor(A);
  EigenProblem problem = testing::unit_mass_problem(A, factor);
  const double a = 0.3;
  problem.shift = a;
  problem.multiply_K = [&A, a](const auto& X, auto& Y) {
    A.multiply(X, Y);
    Y -= a * X;
  };
  const std::vector<double> exact = grid_eigenvalues(n);
  const EigenPairs pairs = solve(problem, {8, 0.0, 1e-9});
  for (int k = 0; k < 8; ++k) EXPECT_NEAR(pairs.omega2(k), exact[k] - a, 1e-13);
}

INSTANTIATE_TEST_SUITE_P(Both, Eigensolvers, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "BlockLanczos" : "KrylovSchur"; });

}  // namespace
}  // namespace flexura::linalg
