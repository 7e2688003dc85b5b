// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/complex_factors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

namespace flexura::mbs {
namespace {

using Eigen::MatrixXcd;
using Eigen::VectorXcd;

// Sizes on both sides of the four columns that are taken together; the same object for all of them.
TEST(ComplexFactors, SolveToRoundOff) {
  std::srand(5);
  ComplexFactors factors;
  for (const int n : {1, 2, 3, 4, 5, 8, 11, 70, 33}) {
    SCOPED_TRACE(n);
    MatrixXcd A = MatrixXcd::Random(n, n);
    // Without pivoting the first step would divide by zero.
    if (n > 1) A(0, 0) = 0.0;
    const VectorXcd b = VectorXcd::Random(n);
    factors.compute(A);
    VectorXcd x = b;
    factors.solve_in_place(x);
    // |b - A x| <= 3 n eps rho |A| |x| with a growth rho of the pivots that stays below n^(2/3) for random
    // matrices (Higham, theorem 9.5 and section 9.4).
    const double eps = std::numeric_limits<double>::epsilon();
    EXPECT_LE((b - A * x).norm(), 3.0 * n * eps * std::pow(n, 2.0 / 3.0) * A.norm() * x.norm());
  }
}

TEST(ComplexFactors, ASingularMatrixGivesWhatIsNotFinite) {
  ComplexFactors factors;
  factors.compute(MatrixXcd::Ones(3, 3));
  VectorXcd x = VectorXcd::Ones(3);
  factors.solve_in_place(x);
  EXPECT_FALSE(x.allFinite());
}

}  // namespace
}  // namespace flexura::mbs
