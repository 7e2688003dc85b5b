// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <functional>

#include "mbs/solver/linear/linearise.hpp"
#include "tests/mbs/cases/case_run.hpp"
#include "tests/reference.hpp"

/// The Whipple bicycle against J. P. Meijaard, J. M. Papadopoulos, A. Ruina, A. L. Schwab, Proc. R. Soc. A
/// 463 (2007) 1955-1982, table 2.
namespace flexura::mbs::cases {
namespace {

std::vector<std::complex<double>> eigenvalues(double v) {
  const PreparedMechanism p = prepare_case("bicycle/bicycle.toml", {fmt::format("parameters.v={:.17g}", v)});
  std::vector<std::complex<double>> values;
  for (const NaturalMode& mode : natural_modes(linearise(*p.mechanism, p.state)))
    values.push_back(mode.eigenvalue);
  return values;
}

// The oscillating mode's real part.
double weave(double v) {
  for (const auto& value : eigenvalues(v))
    if (value.imag() > 0.1) return value.real();
  throw std::runtime_error("no oscillating mode");
}

// The real eigenvalue that is nearest to zero beside the two of rolling on, which are exactly zero:
// differences of 1e-5 leave them within 1e-4 of it, two of opposite signs or an imaginary pair.  Their sum
// and the capsize mode's remain.
double capsize(double v) {
  double sum = 0.0;
  for (const auto& value : eigenvalues(v))
    if (std::abs(value.imag()) < 0.1 && std::abs(value.real()) < 1.0) sum += value.real();
  return sum;
}

double crossing(const std::function<double(double)>& f, double a, double b) {
  double fa = f(a), fb = f(b);
  for (int i = 0; i < 12 && std::abs(b - a) > 1e-9; ++i) {
    const double c = b - fb * (b - a) / (fb - fa);
    a = b, fa = fb;
    b = c, fb = f(c);
  }
  return b;
}

const test::Reference benchmark = {"Whipple bicycle: Meijaard, Papadopoulos, Ruina, Schwab (2007), 14 digits",
                                   "central differences with steps of 1e-5 leave 1e-8"};

TEST(Bicycle, WeavesAndCapsizesAtThePublishedSpeeds) {
  // Central differences with steps of 1e-5 leave 1e-8 in the eigenvalues, whose slopes over the speed are 1.5
  // and 0.3.
  test::expect_reference("weave speed", "m/s", crossing(weave, 4.0, 4.5), 4.29238253634111, 1e-6, benchmark);
  test::expect_reference("capsize speed", "m/s", crossing(capsize, 5.8, 6.2), 6.02426201538837, 1e-6,
                         benchmark);
}

TEST(Bicycle, HasThePublishedEigenvaluesAtFiveMetresPerSecond) {
  double castering = 0.0;
  std::complex<double> weaving;
  for (const auto& value : eigenvalues(5.0)) {
    castering = std::min(castering, value.real());
    if (value.imag() > 0.1) weaving = value;
  }
  test::expect_reference("castering at 5 m/s", "1/s", castering, -14.07838969279822, 1e-6, benchmark);
  test::expect_reference("weave at 5 m/s, real", "1/s", weaving.real(), -0.77534188219585, 1e-6, benchmark);
  test::expect_reference("weave at 5 m/s, imaginary", "1/s", weaving.imag(), 4.46486771378823, 1e-6,
                         benchmark);
  test::expect_reference("capsize at 5 m/s", "1/s", capsize(5.0), -0.32286642900409, 1e-6, benchmark);
}

TEST(Bicycle, HasThreeFreedomsOfVelocity) {
  const PreparedMechanism p = prepare_case("bicycle/bicycle.toml");
  EXPECT_EQ(p.mechanism->sizes().n_v - p.mechanism->sizes().n_lambda, 3);
  EXPECT_TRUE(p.redundant.empty());
}

}  // namespace
}  // namespace flexura::mbs::cases
