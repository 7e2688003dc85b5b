// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/beam/exact/timoshenko.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace exact {
namespace {

TEST(ExactBeam, EulerBernoulliConstantsOfTheTextbooks) {
  // (beta L)^2, printed digits; half a unit of the last one, 5e-7, relative to the value.
  const double cantilever[] = {3.516015, 22.034492, 61.697214, 120.901916};
  const double free[] = {22.373285, 61.672823, 120.903392};
  const auto c = bending_frequencies({}, End::clamped, End::free, 4);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(c[k], cantilever[k], 6e-7);
  for (const auto& roots : {bending_frequencies({}, End::free, End::free, 3),
                            bending_frequencies({}, End::clamped, End::clamped, 3)})
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(roots[k], free[k], 6e-7);
}

TEST(ExactBeam, PinnedTimoshenkoBeamMatchesPublishedNumbers) {
  // L = 2, 0.4 x 0.4, E = 1e9, rho = 7850, nu = 0.3, kappa = 10 (1 + nu) / (12 + 11 nu): rad/s, six decimals.
  const double A = 0.16, I = 0.4 * 0.4 * 0.4 * 0.4 / 12, G = 1e9 / 2.6;
  const Beam beam{2.0, 1e9 * I, 7850 * A, 7850 * I, 15.3 / (13.0 * G * A)};
  const double first[] = {95.633981, 332.234514, 635.696288}, second[] = {1878.8718, 2163.3392, 2543.9128};
  const auto roots = bending_frequencies(beam, End::pinned, End::pinned, 3);
  for (int n = 1; n <= 3; ++n) {
    EXPECT_NEAR(roots[n - 1], first[n - 1], 1e-6);
    EXPECT_NEAR(pinned_frequencies(beam, n).first, first[n - 1], 1e-6);
    EXPECT_NEAR(pinned_frequencies(beam, n).second, second[n - 1], 1e-4);
  }
}

TEST(ExactBeam, FreeShaftOfTheTheorySheet) {
  // d = 0.25 m, l = 1 m, E = 2.1e11, nu = 0.3, rho = 7850, Cowper's kappa: 1004.05 and 2317.85 Hz (two
  // decimals).
  const double d = 0.25, A = std::numbers::pi * d * d / 4, I = std::numbers::pi * std::pow(d, 4) / 64;
  const double kappa = 6 * 1.3 / (7 + 6 * 0.3), G = 2.1e11 / 2.6;
  const Beam beam{1.0, 2.1e11 * I, 7850 * A, 7850 * I, 1 / (kappa * G * A)};
  const auto f = bending_frequencies(beam, End::free, End::free, 2);
  EXPECT_NEAR(f[0] / (2 * std::numbers::pi), 1004.05, 0.006);
  EXPECT_NEAR(f[1] / (2 * std::numbers::pi), 2317.85, 0.006);
}

}  // namespace
}  // namespace exact
