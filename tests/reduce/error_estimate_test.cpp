// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/errors/error_estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "reduce/cms/shapes/full_model.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;

struct Case {
  const char* name;
  Eigen::Vector3d size;
  std::array<int, 3> n;
  Tie right;
  int n_modes;
};

class ErrorEstimate : public ::testing::TestWithParam<Case> {};

// Estimate over true error for isolated modes below half the first dropped eigenvalue: 0.8 to 1.05 is wanted.
// By Rayleigh and Ritz it is at most 1, but for the round-off of the truth: eigenvalues to 1e-9, errors above
// 1e-7. The safe form is never below 1.  Sizes are unequal so that modes do not pair; the last two are as
// thick as long.
TEST_P(ErrorEstimate, IsTheTrueErrorOfIsolatedModes) {
  const Case& c = GetParam();
  const Part part = beam(c.size, c.n, mesh::CellType::tet10, Tie::rigid, c.right);
  ReductionOptions options;
  options.n_modes = c.n_modes;
  const Reduction se = craig_bampton(part, options);
  const std::vector<ModeError> errors = mode_errors(se);
  const linalg::EigenPairs full = full_free_modes(part, c.n_modes, errors[0].omega2);
  int n_judged = 0;
  for (int k = 0; k < c.n_modes; ++k) {
    const ModeError& e = errors[k];
    const double truth = (e.omega2 - full.omega2(6 + k)) / full.omega2(6 + k);
    if (!e.isolated || e.omega2 > 0.5 * se.omega2_dropped || truth < 1e-7)
      continue;  // 1e-7: round-off of truth is 1e-9
    ++n_judged;
    EXPECT_GT(e.estimate / truth, 0.8) << "mode " << k;
    EXPECT_LT(e.estimate / truth, 1.02) << "mode " << k;
    EXPECT_GT(e.safe_estimate / truth, 1.0) << "mode " << k;
    EXPECT_LT(e.safe_estimate / truth, 2.1) << "mode " << k;
  }
  EXPECT_GE(n_judged, 1);
}

TEST_P(ErrorEstimate, FallsAsModesAreAdded) {
  const Case& c = GetParam();
  const Part part = beam(c.size, c.n, mesh::CellType::tet10, Tie::rigid, c.right);
  double before = std::numeric_limits<double>::infinity();
  for (int n_modes : {c.n_modes, 2 * c.n_modes, 4 * c.n_modes}) {
    ReductionOptions options;
    options.n_modes = n_modes;
    const Reduction se = craig_bampton(part, options);
    const double error = interface_error(se, 0.3 * std::sqrt(se.omega2(0)));
    EXPECT_LT(error, before);
    EXPECT_GT(error, 0.0);
    before = error;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Parts, ErrorEstimate,
    ::testing::Values(Case{"Rod", {1.0, 0.05, 0.08}, {12, 1, 2}, Tie::rigid, 10},
                      Case{"Block", {0.2, 0.11, 0.07}, {5, 3, 2}, Tie::rigid, 16},
                      Case{"Plate", {0.3, 0.17, 0.02}, {7, 4, 1}, Tie::rigid, 12},
                      Case{"AveragedBlock", {0.2, 0.11, 0.07}, {5, 3, 2}, Tie::average, 16},
                      Case{"Beam", {0.8, 0.07, 0.11}, {10, 1, 2}, Tie::rigid, 12},
                      Case{"AveragedRod", {1.0, 0.05, 0.08}, {12, 1, 2}, Tie::average, 10},
                      Case{"Strip", {0.5, 0.05, 0.013}, {12, 2, 1}, Tie::rigid, 10},
                      Case{"Bar", {0.6, 0.04, 0.065}, {10, 1, 2}, Tie::rigid, 12},
                      Case{"Lath", {0.9, 0.06, 0.025}, {14, 2, 1}, Tie::average, 10},
                      Case{"AveragedBeam", {0.8, 0.07, 0.11}, {10, 1, 2}, Tie::average, 12},
                      Case{"Cube", {0.11, 0.1, 0.09}, {3, 3, 3}, Tie::rigid, 20},
                      Case{"Panel", {0.3, 0.23, 0.015}, {6, 5, 1}, Tie::average, 16}),
    [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace flexura::reduce
