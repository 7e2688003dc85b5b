// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/linear_correction.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace flexura::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Sums of 3 n products of numbers below one, in another order.
TEST(StepOperators, AreThreeProducts) {
  for (const Index n : {1, 3, 4, 12, 13, 21, 30})
    for (const Index columns : {1, 2, 4, 5, 7}) {
      std::srand(static_cast<unsigned>(100 * n + columns));
      const MatrixXd A = MatrixXd::Random(n, n), B = MatrixXd::Random(n, n), C = MatrixXd::Random(n, n);
      const MatrixXd x = MatrixXd::Random(n, columns), y = MatrixXd::Random(n, columns),
                     z = MatrixXd::Random(n, columns);
      StepOperator all;
      all.set({&A, &B, &C});
      MatrixXd next;
      all.apply(x, y, z, next);
      ASSERT_EQ(next.rows(), n);
      ASSERT_EQ(next.cols(), columns);
      EXPECT_LE((next - (A * x + B * y + C * z)).cwiseAbs().maxCoeff(),
                6.0 * static_cast<double>(n) * std::numeric_limits<double>::epsilon())
          << n << " x " << columns;
    }
}

// Two bodies, a spring on each, that a constraint holds together are one body on both springs: the same method must say the
// same of both, to round-off, whether the row of the constraint stays as it is or only its size changes on the way (which
// the method must take for a constraint that moves).
class TwoHeldTogether : public ::testing::TestWithParam<bool> {};

TEST_P(TwoHeldTogether, MoveAsOne) {
  constexpr double m1 = 2.0, m2 = 3.0, k1 = 4e4, k2 = 6e4, d1 = 8.0, d2 = 12.0;
  LinearisedRow two, one;
  two.M = VectorXd{{m1, m2}}.asDiagonal();
  two.D = VectorXd{{d1, d2}}.asDiagonal();
  two.K = VectorXd{{k1, k2}}.asDiagonal();
  one.M = MatrixXd::Constant(1, 1, m1 + m2);
  one.D = MatrixXd::Constant(1, 1, d1 + d2);
  one.K = MatrixXd::Constant(1, 1, k1 + k2);
  two.number = one.number = 1;
  const MatrixXd G{{1.0, -1.0}}, none(0, 1);
  LinearCorrection of_two(2, 2), of_one(1, 2);
  Transients rings_two, rings_one;
  const VectorXd omega2 = VectorXd::Constant(1, (k1 + k2) / (m1 + m2)),
                 damping = VectorXd::Constant(1, (d1 + d2) / (m1 + m2));
  rings_two.add(omega2, damping);
  rings_one.add(omega2, damping);
  const MatrixXd load{{1.0, 0.0}, {2.0, 5.0}}, whole = load.colwise().sum();
  double largest = 0.0;
  for (int i = 0; i <= 20; ++i) {
    const double h = i == 0 ? 0.0 : 0.05;  // some 40 steps of a twelfth of a period of 44 ms fit in each row
    of_two.step(h, two, GetParam() ? MatrixXd((1.0 + 0.1 * i) * G) : G, load, &rings_two, false);
    of_one.step(h, one, none, whole, &rings_one, false);
    largest = std::max(largest, of_one.delta().cwiseAbs().maxCoeff());
    // The constraint is solved with a part in 1e12 on its diagonal.
    for (Index row = 0; row < 2; ++row)
      ASSERT_LE((of_two.delta().row(row) - of_one.delta().row(0)).cwiseAbs().maxCoeff(), 1e-9 * largest) << i;
    ASSERT_EQ(of_two.dlambda().rows(), 1);
  }
  // It rings about where the springs carry the load.
  EXPECT_GT(largest, 1.5 * 5.0 / (k1 + k2));
}

INSTANTIATE_TEST_SUITE_P(LinearCorrections, TwoHeldTogether, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "ByARowThatMoves" : "ByARowThatStays"; });

}  // namespace
}  // namespace flexura::study
