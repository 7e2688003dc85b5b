// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "reduce/linalg/factor/cholesky.hpp"
#include "reduce/linalg/factor/inertia.hpp"
#include "tests/reduce/parts.hpp"

// Factors in single precision, whose round-off (6e-8) is far above what eigenvalues near the shift allow.
namespace flexura::linalg {
namespace {

using reduce::testing::random_matrix;

const FactorStorage kSingle{.single = true};

// The Laplacian of an n x n grid less sigma: eigenvalues 4 - 2 cos(i h) - 2 cos(j h) - sigma, h = pi / (n + 1).
SymmetricMatrix grid_less(int n, double sigma) {
  std::vector<int> begin{0}, columns;
  for (int i = 0; i < n * n; ++i) {
    columns.push_back(i);
    if (i % n + 1 < n) columns.push_back(i + 1);
    if (i + n < n * n) columns.push_back(i + n);
    begin.push_back(static_cast<int>(columns.size()));
  }
  SymmetricMatrix A(begin, columns);
  for (int i = 0; i < n * n; ++i) {
    A.add_to_entry(i, i, 4.0 - sigma);
    if (i % n + 1 < n) A.add_to_entry(i, i + 1, -1.0);
    if (i + n < n * n) A.add_to_entry(i, i + n, -1.0);
  }
  A.finish();
  return A;
}

std::vector<double> eigenvalues_of_grid(int n) {
  std::vector<double> values;
  const double h = std::numbers::pi / (n + 1);
  for (int i = 1; i <= n; ++i)
    for (int j = 1; j <= n; ++j) values.push_back(4.0 - 2.0 * std::cos(i * h) - 2.0 * std::cos(j * h));
  std::sort(values.begin(), values.end());
  return values;
}

TEST(SinglePrecision, CountsEigenvaluesAndSolvesAsDoublePrecisionDoesInHalfTheMemory) {
  const int n = 90;
  const std::vector<double> exact = eigenvalues_of_grid(n);
  const Eigen::MatrixXd B = random_matrix(n * n, 11);
  for (const double sigma : {-1.0, 0.5 * (exact[2] + exact[3]), 0.02, 0.1}) {
    const SymmetricMatrix A = grid_less(n, sigma);
    const IndefiniteFactor single(A, {}, kSingle), twice(A);
    EXPECT_TRUE(single.figures().single) << "sigma " << sigma;
    EXPECT_FALSE(twice.figures().single);
    EXPECT_EQ(2.0 * single.figures().bytes, twice.figures().bytes);
    EXPECT_EQ(single.n_negative(), std::lower_bound(exact.begin(), exact.end(), sigma) - exact.begin());
    // Eigenvalues are 1e-4 away or more, the largest is 8: condition number 1e5, times 1e-16, times growth.
    Eigen::MatrixXd AX;
    A.multiply(single.solve(B), AX);
    EXPECT_LT((AX - B).norm(), 1e-9 * B.norm()) << "sigma " << sigma;
  }
}

// Whatever the distance to an eigenvalue, the count is right: where single precision could have taken it past zero, the
// matrix is factorised in double precision.  That may refuse (the limit is to be moved), but never miscount.
TEST(SinglePrecision, NearAnEigenvalueTheMatrixIsFactorisedInDoublePrecision) {
  const int n = 40;
  const std::vector<double> exact = eigenvalues_of_grid(n);
  int singles = 0, doubles = 0;
  for (const int mode : {0, 5, 23})
    for (double distance = 1e-3; distance > 1e-12; distance *= 0.1)
      for (const double side : {-1.0, 1.0}) {
        const double sigma = exact[static_cast<std::size_t>(mode)] + side * distance;
        const IndefiniteFactor factor(grid_less(n, sigma), {}, kSingle);
        EXPECT_EQ(factor.n_negative(), std::lower_bound(exact.begin(), exact.end(), sigma) - exact.begin())
            << side * distance << " from mode " << mode;
        ++(factor.figures().single ? singles : doubles);
      }
  EXPECT_GT(singles, 18);  // distances down to 1e-5
  EXPECT_GT(doubles, 18);  // 1e-10 and below: 1e-3 of single precision's round-off
}

// Its lowest eigenvalue is -1e-9: single precision alone may well find a Cholesky factor.
TEST(SinglePrecision, AMatrixThatIsNotQuiteDefiniteIsRefused) {
  const int n = 40;
  const double lowest = eigenvalues_of_grid(n)[0];
  EXPECT_THROW(CholeskyFactor(grid_less(n, lowest + 1e-9), {}, {}, kSingle), SingularMatrix);
  const SymmetricMatrix A = grid_less(n, lowest - 1e-9);
  const CholeskyFactor factor(A, {}, {}, kSingle);
  EXPECT_FALSE(factor.figures().single);
  const Eigen::MatrixXd B = random_matrix(n * n, 3);
  Eigen::MatrixXd AX;
  A.multiply(factor.solve(B), AX);
  EXPECT_LT((AX - B).norm(), 1e-5 * B.norm());  // condition number 1e10, times 1e-16, times growth
}

}  // namespace
}  // namespace flexura::linalg
