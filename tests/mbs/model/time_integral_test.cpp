// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/time_integral.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace flexura::mbs {
namespace {

TimeIntegral integral_of(const std::string& text) {
  const Expression f("joint.j.drive_acceleration", text, SignalNames(), {});
  return TimeIntegral(TimeFunction(f.where(), true, f.tree(), f.tree().root, [](int) { return nullptr; }));
}

struct Known {
  std::string text;
  double (*integral)(double t);
  double error;  // relative to the largest value of the integral until 10 s, unless said
};

class Integrals : public ::testing::TestWithParam<Known> {};
// Asked forwards, backwards and in between; 1e-13 is round-off of the sum of some hundred panels, pulses have the width that
// the difference of their two times has in numbers of their size.
TEST_P(Integrals, AreWhatTheyAreInClosedForm) {
  for (const double first : {1e-9, 10.0}) {
    const TimeIntegral integral = integral_of(GetParam().text);
    for (const double t : {first, 1e-6, 0.31, 0.7, 2.0, 3.30005, 5.0, 10.0, -1.0, 0.0})
      EXPECT_NEAR(integral(t), GetParam().integral(t), GetParam().error) << GetParam().text << " until " << t;
  }
}
INSTANTIATE_TEST_SUITE_P(
    TimeIntegral, Integrals,
    ::testing::Values(
        Known{"3", [](double t) { return 3 * t; }, 1e-13},
        // Whose relative round-off near 0 is without bound: it was divided until the age of the universe.
        Known{"t < 0.1 ? 500*(1 - cos(2*pi*t/0.1)) : 0",
              [](double t) {
                const double end = std::min(t, 0.1), w = 2 * std::numbers::pi / 0.1;
                return 500 * (end - std::sin(w * end) / w);
              },
              1e-10},
        // Which was stepped over.
        Known{"t > 0.7 && t < 0.7 + 1e-9 ? 1e9 : 0", [](double t) { return t > 0.7 ? 1.0 : 0.0; }, 3e-7},
        Known{
            "exp(-((t - 5)/0.0005)^2)",
            [](double t) { return 0.00025 * std::sqrt(std::numbers::pi) * (1 + std::erf((t - 5) / 0.0005)); },
            1e-15},
        Known{"sin(40*t)", [](double t) { return (1 - std::cos(40 * t)) / 40; }, 1e-13},
        Known{"sign(sin(2*pi*t))",
              [](double t) {
                const double x = std::abs(t) - std::floor(std::abs(t));
                return std::min(x, 1 - x);
              },
              1e-12},
        Known{"abs(t - 3.3)",
              [](double t) {
                const auto F = [](double x) { return 0.5 * (x - 3.3) * std::abs(x - 3.3); };
                return F(t) - F(0);
              },
              1e-13},
        Known{"floor(t)",
              [](double t) {
                const double n = std::floor(t);
                return n * (n - 1) / 2 + n * (t - n);
              },
              1e-13}));

}  // namespace
}  // namespace flexura::mbs
