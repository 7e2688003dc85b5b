// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <utility>
#include <vector>

#include "reduce/assembly/tied_solver.hpp"
#include "reduce/cms/shapes/fixed_interface.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/linalg/eigen/eigensolver.hpp"
#include "reduce/linalg/session/user_options.hpp"
#include "tests/reduce/parts.hpp"

// Slices of the spectrum of parts, against dense eigenvalues of the same K_ii and M_ii where u_i is in the null space of the
// averages.
namespace flexura::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd dense_omega2(const TiedModel& model) {
  const Index n = model.n_i(), n_a = model.A().rows();
  MatrixXd N = MatrixXd::Identity(n, n), M;
  model.matrices().multiply_M_ii(N, M);
  if (n_a > 0) {
    const Eigen::HouseholderQR<MatrixXd> qr(MatrixXd(model.A().transpose()));
    N = MatrixXd(qr.householderQ()).rightCols(n - n_a);
  }
  return linalg::generalized_eigen(N.transpose() * testing::dense(model.K_ii()) * N, N.transpose() * M * N)
      .values;
}

class Ties : public ::testing::TestWithParam<std::pair<Tie, Tie>> {};

// The bar is square: its bending modes come in pairs.
TEST_P(Ties, SlicesFindTheDenseEigenvaluesAndCountThem) {
  const auto [left, right] = GetParam();
  const TiedModel model(testing::beam({0.8, 0.1, 0.1}, {10, 2, 2}, mesh::CellType::hex20, left, right));
  const TiedSolver solver(model);
  const VectorXd exact = dense_omega2(model);
  linalg::EigenProblem problem = fixed_interface_problem(model, solver);
  int n_shifts = 0;
  problem.shifted = [&, shifted = problem.shifted](double sigma) {
    linalg::EigenProblem::Shifted shift = shifted(sigma);
    EXPECT_EQ(shift.n_below, (exact.array() < sigma).count()) << sigma;
    ++n_shifts;
    return shift;
  };
  const linalg::UserOptions options(linalg::parse_options("-eps_blocklanczos_slice 50"));
  const linalg::EigenPairs pairs = linalg::block_lanczos(problem, {250, 0.0, 1e-9});
  ASSERT_GE(pairs.omega2.size(), 250);
  EXPECT_TRUE(pairs.counted);
  EXPECT_GE(n_shifts, 4);
  const Index n = pairs.omega2.size();
  // Dense eigenvalues are off by ulps of the largest one, 1e5 times the lowest of these.
  EXPECT_LT((pairs.omega2 - exact.head(n)).cwiseQuotient(exact.head(n)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(pairs.omega2_next / exact(n), 1.0, 1e-6);
  MatrixXd M_Phi;
  model.matrices().multiply_M_ii(pairs.Phi, M_Phi);
  EXPECT_LT((pairs.Phi.transpose() * M_Phi - MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-10);
  if (model.A().rows() > 0) EXPECT_LT((model.A() * pairs.Phi).norm(), 1e-9 * pairs.Phi.norm());
}

INSTANTIATE_TEST_SUITE_P(SpectrumSlices, Ties,
                         ::testing::Values(std::pair{Tie::rigid, Tie::rigid},
                                           std::pair{Tie::rigid, Tie::average},
                                           std::pair{Tie::average, Tie::average}));

}  // namespace
}  // namespace flexura::reduce
