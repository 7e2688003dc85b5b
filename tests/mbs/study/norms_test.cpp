// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/norms.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "mbs/study/front.hpp"

namespace flexura::study {
namespace {

constexpr double kPi = std::numbers::pi;

Signal sampled(int n, double span, auto&& f) {
  Signal s{Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (int i = 0; i < n; ++i) {
    s.time(i) = span * i / (n - 1);
    s.value(i) = f(s.time(i));
  }
  return s;
}

TEST(Norms, OfASineAndItsScaledCopyAreTheFactor) {
  // 2001 rows over whole periods that hit the crests: max, peak and mean are exact to round-off; the
  // trapezoidal rule over whole periods of a smooth periodic function is exact to round-off too.
  const Signal y = sampled(2001, 1.0, [](double t) { return std::sin(10 * kPi * t); });
  Signal z = y;
  z.value *= 1.25;
  EXPECT_NEAR(size_of(y, Norm::max), 1.0, 1e-12);
  EXPECT_NEAR(size_of(y, Norm::rms), std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(difference(z, y, Norm::max), 0.25, 1e-12);
  EXPECT_NEAR(difference(z, y, Norm::rms) / size_of(y, Norm::rms), 0.25, 1e-12);
  EXPECT_NEAR(difference(z, y, Norm::peak), 0.25, 1e-12);
  EXPECT_NEAR(difference(z, y, Norm::mean), 0.0, 1e-12);
  z.value.array() += 0.5;
  EXPECT_NEAR(difference(z, y, Norm::mean), 0.5, 1e-12);
  EXPECT_NEAR(difference(z, y, Norm::final), 0.5, 1e-12);
}

TEST(Norms, RmsOfARampOnUnevenRowsIsItsIntegral) {
  // y = t on uneven rows: the trapezoidal rule of t^2 errs by h^2/6 at most, rms^2 = 1/3.
  Signal y = sampled(401, 1.0, [](double t) { return t; });
  y.time = y.time.array().square();
  y.value = y.time;
  const double h = 2.0 / 400;  // the largest step
  EXPECT_NEAR(size_of(y, Norm::rms), std::sqrt(1.0 / 3.0), h * h / 6.0);
}

TEST(Norms, FrequencyOfADecayingVibrationIsItsOwnNotTheNearestLine) {
  // 12.34 Hz over one second: lines of a discrete transform stand 1 Hz apart.  A decay exp(-t) widens the
  // line symmetrically; what moves its maximum is the mirror line at -12.34 Hz, whose Hann side lobes fall
  // as (f span)^-3: 1/(2*12.34)^3 / pi = 2e-5 lines.
  const Signal y =
      sampled(1001, 1.0, [](double t) { return 3.0 + std::exp(-t) * std::sin(2 * kPi * 12.34 * t); });
  EXPECT_NEAR(dominant_frequency(y), 12.34, 1e-3);
  EXPECT_EQ(dominant_frequency(sampled(100, 1.0, [](double) { return 7.0; })), 0.0);
}

TEST(Norms, SignalsAtDifferentTimesAreRefused) {
  const Signal y = sampled(11, 1.0, [](double t) { return t; }),
               z = sampled(11, 1.1, [](double t) { return t; });
  EXPECT_THROW(difference(z, y, Norm::max), std::invalid_argument);
  EXPECT_NEAR(difference(z, y, Norm::final), 0.1, 1e-15);
}

TEST(Norms, WindowKeepsItsEnds) {
  const Signal y = sampled(11, 1.0, [](double t) { return t; });
  const Signal w = window(y, 0.3, 0.6);  // 0.3 and 0.6 are not the rows' floating-point values
  ASSERT_EQ(w.time.size(), 4);
  EXPECT_NEAR(w.value(0), 0.3, 1e-15);
  EXPECT_NEAR(w.value(3), 0.6, 1e-15);
}

TEST(Front, KeepsWhatNothingBeats) {
  const double infinite = std::numeric_limits<double>::infinity();
  const std::vector<TradePoint> points = {{1, 0.5}, {2, 0.1},        {3, 0.2}, {4, 0.01},
                                          {2, 0.1}, {0.5, infinite}, {4, 0.02}};
  EXPECT_EQ(pareto_front(points), (std::vector<bool>{true, true, false, true, true, false, false}));
  EXPECT_EQ(cheapest_within(points, 0.2).value(), 1u);
  EXPECT_EQ(cheapest_within(points, 0.05).value(), 3u);
  EXPECT_FALSE(cheapest_within(points, 0.001));
  EXPECT_EQ(most_accurate_within(points, 3.0).value(), 1u);
  EXPECT_FALSE(most_accurate_within(points, 0.7));
}

}  // namespace
}  // namespace flexura::study
