// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "reduce/linalg/eigen/eigensolver.hpp"
#include "reduce/linalg/eigen/spectrum_slices.hpp"
#include "reduce/linalg/factor/cholesky.hpp"
#include "reduce/linalg/factor/inertia.hpp"
#include "tests/reduce/petsc/petsc_options.hpp"
#include "tests/reduce/unit_masses.hpp"

// Slices of the spectrum (spectrum_slices.hpp), against the exact eigenvalues of grids of springs.
namespace flexura::linalg {
namespace {

using testing::Options;

// Unit masses on an n_x x n_y x n_z grid with unit springs between neighbours; held beyond its ends, or free (then the uniform
// motion costs nothing).  Eigenvalues are sums of 2 - 2 cos(k pi / (n + 1)), k = 1 ... n, and of 2 - 2 cos(k pi / n),
// k = 0 ... n - 1, one term for each direction.
class Springs {
 public:
  Springs(int n_x, int n_y, int n_z, bool is_free = false) {
    const int sides[] = {n_x, n_y, n_z}, steps[] = {1, n_x, n_x * n_y};
    const int n = n_x * n_y * n_z;
    std::vector<int> begin{0}, columns;
    for (int i = 0; i < n; ++i) {
      columns.push_back(i);
      for (int d = 0; d < 3; ++d)
        if (i / steps[d] % sides[d] + 1 < sides[d]) columns.push_back(i + steps[d]);
      begin.push_back(static_cast<int>(columns.size()));
    }
    K_ = std::make_unique<SymmetricMatrix>(begin, columns);
    for (int i = 0; i < n; ++i)
      for (int d = 0; d < 3; ++d) {
        if (sides[d] == 1) continue;
        const int place = i / steps[d] % sides[d];
        const bool ends = place == 0, last = place + 1 == sides[d];
        K_->add_to_diagonal(i, 2.0 - (is_free ? (ends ? 1.0 : 0.0) + (last ? 1.0 : 0.0) : 0.0));
        if (!last) K_->add_to_entry(i, i + steps[d], -1.0);
      }
    K_->finish();
    exact_.push_back(0.0);
    for (const int side : sides) {
      if (side == 1) continue;
      std::vector<double> sums;
      for (const double before : exact_)
        for (int k = 0; k < side; ++k)
          sums.push_back(before + 2.0 -
                         2.0 * std::cos(is_free ? k * std::numbers::pi / side
                                                : (k + 1) * std::numbers::pi / (side + 1)));
      exact_ = sums;
    }
    std::sort(exact_.begin(), exact_.end());
    shift_ = is_free ? 0.01 : 0.0;
    factor_ = std::make_unique<CholeskyFactor>(shifted(-shift_));
  }

  EigenProblem problem() {
    EigenProblem problem = testing::unit_mass_problem(*K_, *factor_);
    problem.shift = shift_;
    problem.shifted = [this](double sigma) {
      auto factor = std::make_shared<const IndefiniteFactor>(shifted(sigma));
      shifts_.push_back(sigma);
      counts_.push_back(factor->n_negative() + wrong_by_);
      return EigenProblem::Shifted{[factor](const auto& X, auto& Y) { Y = factor->solve(X); },
                                   counts_.back()};
    };
    return problem;
  }
  void count_wrong_by(int difference) { wrong_by_ = difference; }

  const std::vector<double>& exact() const { return exact_; }
  Eigen::Index n_exact_below(double sigma) const {
    return std::lower_bound(exact_.begin(), exact_.end(), sigma) - exact_.begin();
  }
  const std::vector<double>& shifts() const { return shifts_; }

  // Every pair is that of its number, each shift has counted what lies below it.
  void expect(const EigenPairs& pairs, Eigen::Index count) const {
    expect_exact(pairs, count);
    EXPECT_TRUE(pairs.counted);
  }
  void expect_exact(const EigenPairs& pairs, Eigen::Index count) const {
    ASSERT_GE(pairs.omega2.size(), count);
    for (Eigen::Index k = 0; k < pairs.omega2.size(); ++k)
      // Eigenvalues are accurate to the square of the residual, so to round-off: some ulps of the largest one (12).
      EXPECT_NEAR(pairs.omega2(k), exact_[static_cast<std::size_t>(k)], 2e-13) << "pair " << k;
    EXPECT_LT(pairs.residual.maxCoeff(), 1e-9);
    const Eigen::MatrixXd gram = pairs.Phi.transpose() * pairs.Phi;
    EXPECT_LT((gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(), 1e-11);
    // What is called counted lies below the last shift.
    if (pairs.counted) EXPECT_GT(shifts_.back(), pairs.omega2(pairs.omega2.size() - 1));
    for (std::size_t s = 0; s < shifts_.size(); ++s)
      EXPECT_EQ(counts_[s], n_exact_below(shifts_[s])) << "shift " << shifts_[s];
  }

 private:
  SymmetricMatrix shifted(double sigma) const {
    SymmetricMatrix A = K_->copy();
    for (int i = 0; i < A.size(); ++i) A.add_to_diagonal(i, -sigma);
    A.finish();
    return A;
  }

  std::unique_ptr<SymmetricMatrix> K_;
  std::unique_ptr<CholeskyFactor> factor_;
  double shift_ = 0.0;
  int wrong_by_ = 0;
  std::vector<double> exact_, shifts_;
  std::vector<int> counts_;
};

TEST(Slices, FindTheDoubleEigenvaluesOfASquareGrid) {
  const Options options("-eps_blocklanczos_slice", "60");
  Springs springs(40, 40, 1);
  springs.expect(block_lanczos(springs.problem(), {300, 0.0, 1e-9}), 300);
  EXPECT_GE(springs.shifts().size(), 4u);
  EXPECT_LE(springs.shifts().size(), 8u);
}

// A cube's eigenvalues are sixfold and, by chance, more: no slice may end within one of them.
TEST(Slices, EndBesideTheSixfoldEigenvaluesOfACube) {
  const Options options("-eps_blocklanczos_slice", "24");
  Springs springs(11, 11, 11);
  springs.expect(block_lanczos(springs.problem(), {200, 0.0, 1e-9}), 200);
  EXPECT_GE(springs.shifts().size(), 4u);
}

TEST(Slices, BeginWithTheRigidMotionOfAFreeBody) {
  const Options options("-eps_blocklanczos_slice", "30");
  Springs springs(17, 13, 5, true);
  springs.expect(block_lanczos(springs.problem(), {150, 0.0, 1e-9}), 150);
}

TEST(Slices, KeepAClusterAtTheCutWhole) {
  const Options options("-eps_blocklanczos_slice", "20");
  Springs springs(14, 14, 1);
  // The first twins after number 70.
  std::size_t k = 70;
  while (springs.exact()[k] - springs.exact()[k - 1] > 1e-12) ++k;
  const EigenPairs pairs = block_lanczos(springs.problem(), {static_cast<int>(k), 0.0, 1e-9});
  springs.expect(pairs, static_cast<Eigen::Index>(k) + 1);
  EXPECT_NEAR(pairs.omega2_next, springs.exact()[static_cast<std::size_t>(pairs.omega2.size())], 1e-6);
}

TEST(Slices, FindAllUpToALimit) {
  const Options options("-eps_blocklanczos_slice", "40");
  Springs springs(30, 30, 1);
  const std::vector<double>& exact = springs.exact();
  std::size_t k = 200;
  while (exact[k] - exact[k - 1] < 1e-3) ++k;
  const EigenPairs pairs = block_lanczos(springs.problem(), {1, 0.5 * (exact[k - 1] + exact[k]), 1e-9});
  EXPECT_EQ(pairs.omega2.size(), static_cast<Eigen::Index>(k));
  springs.expect(pairs, static_cast<Eigen::Index>(k));
}

TEST(Slices, FindEverythingInASmallSpace) {
  const Options options("-eps_blocklanczos_slice", "8");
  Springs springs(7, 5, 1);
  const EigenPairs pairs = block_lanczos(springs.problem(), {35, 0.0, 1e-9});
  ASSERT_EQ(pairs.omega2.size(), 35);
  for (int k = 0; k < 35; ++k) EXPECT_NEAR(pairs.omega2(k), springs.exact()[k], 1e-13);
  EXPECT_TRUE(std::isinf(pairs.omega2_next));
}

// A cube's frequencies come in sixes, blocks of two see two of each at first.
TEST(Slices, FindMoreOfAMultipleEigenvalueThanABlockHas) {
  const Options slice("-eps_blocklanczos_slice", "20"), block("-eps_blocklanczos_block", "2");
  Springs springs(8, 8, 8);
  std::size_t k = 120;
  while (springs.exact()[k] - springs.exact()[k - 1] < 1e-6) ++k;
  const EigenPairs pairs = block_lanczos(springs.problem(), {static_cast<int>(k), 0.0, 1e-9});
  springs.expect(pairs, static_cast<Eigen::Index>(k));
  EXPECT_TRUE(pairs.counted);
}

TEST(Slices, AreTheSameToTheBitTheNextTime) {
  const Options options("-eps_blocklanczos_slice", "30");
  Springs springs(20, 18, 1);
  const EigenPairs first = block_lanczos(springs.problem(), {90, 0.0, 1e-9}),
                   second = block_lanczos(springs.problem(), {90, 0.0, 1e-9});
  EXPECT_EQ(first.omega2, second.omega2);
  EXPECT_EQ(first.Phi, second.Phi);
}

// A factorisation is worth some hundred solves; the numbers of a part of 300,000 unknowns.
TEST(Slices, AreChosenWhereTheyTakeFewerOperations) {
  EigenProblem problem;
  problem.factor_operations = 1.3e12;
  problem.solve_operations = 1.35e9;
  EXPECT_EQ(modes_per_slice(problem, 3e5, 2000, 16), 0);  // there are no shifts
  problem.shifted = [](double) { return EigenProblem::Shifted{}; };
  EXPECT_EQ(modes_per_slice(problem, 3e5, 50, 16), 0);
  const int modes = modes_per_slice(problem, 3e5, 2000, 16);
  EXPECT_GE(modes, 100);
  EXPECT_LE(modes, 1000);
  // A dear factor makes slices longer, or none at all.
  const int of_more = modes_per_slice(problem, 3e5, 4000, 16);
  problem.factor_operations = 4e12;
  EXPECT_GT(modes_per_slice(problem, 3e5, 4000, 16), of_more);
  problem.factor_operations = 1e15;
  EXPECT_EQ(modes_per_slice(problem, 3e5, 4000, 16), 0);

  Springs springs(40, 40, 1);
  problem = springs.problem();
  problem.factor_operations = 1e6;
  problem.solve_operations = 1e5;
  springs.expect(block_lanczos(problem, {300, 0.0, 1e-9}), 300);
  const Options options("-eps_blocklanczos_slice", "0");
  EXPECT_FALSE(block_lanczos(problem, {300, 0.0, 1e-9}).counted);
}

// The number of modes is not known beforehand: one basis begins and sees it.
TEST(Slices, AreChosenWhereManyModesLieBelowALimit) {
  Springs springs(40, 40, 1);
  EigenProblem problem = springs.problem();
  problem.factor_operations = 1e6;
  problem.solve_operations = 1e5;
  const std::vector<double>& exact = springs.exact();
  std::size_t k = 600;
  while (exact[k] - exact[k - 1] < 1e-3) ++k;
  const EigenPairs pairs = block_lanczos(problem, {1, 0.5 * (exact[k - 1] + exact[k]), 1e-9});
  EXPECT_EQ(pairs.omega2.size(), static_cast<Eigen::Index>(k));
  springs.expect(pairs, static_cast<Eigen::Index>(k));
}

// A square's eigenvalues i^2 + j^2 grow with their number.
TEST(Slices, NumbersBelowALimitAreExpectedByTheGrowthSoFar) {
  const Eigen::VectorXd linear = Eigen::VectorXd::LinSpaced(100, 1.0, 100.0);
  EXPECT_NEAR(expected_below(linear, 1000.0), 1000.0, 30.0);
  EXPECT_NEAR(expected_below(linear.cwiseSqrt(), std::sqrt(1000.0)), 1000.0, 30.0);
  EXPECT_EQ(expected_below(linear, 10.5), 10.0);
}

void expect_refusal(const EigenProblem& problem, const std::string& text) {
  try {
    block_lanczos(problem, {120, 0.0, 1e-9});
    FAIL() << "nothing was thrown; expected: " << text;
  } catch (const std::exception& thrown) {
    EXPECT_THAT(thrown.what(), ::testing::HasSubstr(text));
  }
}

// One eigenvalue too many: from the shift one is taken for new that the slice before has found.
TEST(Slices, AWrongCountIsRefused) {
  const Options options("-eps_blocklanczos_slice", "40");
  Springs springs(21, 18, 1);
  springs.count_wrong_by(1);
  expect_refusal(springs.problem(), "spectrum slices: ");
  // One too few: one that is below the shift is left, and the next shift's count has no place for it.
  springs.count_wrong_by(-1);
  expect_refusal(springs.problem(), "spectrum slices: ");
}

// Round-off that a shift beside an eigenvalue magnifies: another shift is taken.
TEST(Slices, AShiftWhoseSolvesAreInaccurateIsLeft) {
  const Options options("-eps_blocklanczos_slice", "40");
  Springs springs(21, 18, 1);
  EigenProblem problem = springs.problem();
  int n_shifts = 0;
  problem.shifted = [&, exact = problem.shifted](double sigma) {
    EigenProblem::Shifted factor = exact(sigma);
    if (++n_shifts != 2) return factor;
    factor.solve = [solve = factor.solve](const auto& X, auto& Y) {
      solve(X, Y);
      Y.array() *= 1.0 + 1e-5 * Eigen::ArrayXXd::Random(Y.rows(), Y.cols());
    };
    return factor;
  };
  springs.expect(block_lanczos(problem, {120, 0.0, 1e-9}), 120);
  EXPECT_GE(n_shifts, 4);
}

// Grids of any size, many of whose frequencies are multiple, slices and blocks of any width, any number of modes.
TEST(Slices, FindAllThereIsInRandomGrids) {
  std::mt19937 random(24);
  const auto any = [&](int from, int to) {
    return from + static_cast<int>(random() % static_cast<unsigned>(to - from + 1));
  };
  for (int time = 0; time < 60; ++time) {
    const int n_x = any(2, 9), n_y = any(1, 9), n_z = any(1, 6), slice = any(1, 60), block = any(1, 12);
    const int count = any(1, n_x * n_y * n_z);
    const bool is_free = any(0, 1) == 1;
    SCOPED_TRACE(fmt::format("{} x {} x {}, {}, slice {}, block {}, count {}", n_x, n_y, n_z,
                             is_free ? "free" : "held", slice, block, count));
    const Options slices("-eps_blocklanczos_slice", std::to_string(slice).c_str()),
        blocks("-eps_blocklanczos_block", std::to_string(block).c_str());
    Springs springs(n_x, n_y, n_z, is_free);
    try {
      springs.expect_exact(block_lanczos(springs.problem(), {count, 0.0, 1e-9}), count);
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what();
    }
  }
}

// Interface modes, say, which the same options reach.
TEST(Slices, AProblemThatCannotBeShiftedHasOneBasis) {
  const Options options("-eps_blocklanczos_slice", "40");
  Springs springs(21, 18, 1);
  EigenProblem problem = springs.problem();
  problem.shifted = nullptr;
  const EigenPairs pairs = block_lanczos(problem, {60, 0.0, 1e-9});
  EXPECT_FALSE(pairs.counted);
  for (int k = 0; k < 60; ++k) EXPECT_NEAR(pairs.omega2(k), springs.exact()[k], 1e-13);
}

}  // namespace
}  // namespace flexura::linalg
