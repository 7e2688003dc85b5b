// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/growth.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace flexura::mbs::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct Motion {
  std::function<double(double)> kinetic, travel;
};

// The reason after rows up to t_end, and when it came.
std::pair<std::string, double> watch(const Motion& motion, double t_end, double step) {
  GrowthWatch watch;
  for (double t = 0.0; t <= t_end; t += step) {
    watch.observe(t, motion.kinetic(t), motion.travel(t), 0.0);
    if (!watch.reason().empty()) return {watch.reason(), t};
  }
  return {"", t_end};
}

// exp(2 t): the energy exp(4 t) takes ln 10 / 4 = 0.5756 s for a factor of ten; 1e-3 m are 1000 m after ln 1e6 / 2 s.
TEST(GrowthWatch, ExponentialGrowthIsNamedWithItsTimes) {
  const Motion unstable{[](double t) { return 1e-6 * std::exp(4.0 * t); },
                        [](double t) { return 1e-3 * (std::exp(2.0 * t) - 1.0); }};
  const auto [reason, t] = watch(unstable, 100.0, 0.1);
  EXPECT_THAT(reason, AllOf(HasSubstr("without bound"), HasSubstr("tenfold every 0.576 s")));
  EXPECT_GE(t, std::log(1e6) / 2.0);
  EXPECT_LE(t, std::log(1e6) / 2.0 + 0.6 + 0.1);  // at the next factor of ten, seen at the next row
}

// An oscillation that swells: the highest energies so far are what counts.
TEST(GrowthWatch, ASwellingOscillationIsOne) {
  const Motion flutter{[](double t) { return std::exp(t) * std::pow(std::sin(20.0 * t), 2); },
                       [](double t) { return std::exp(0.5 * t); }};
  EXPECT_THAT(watch(flutter, 100.0, 0.01).first, HasSubstr("without bound"));
}

TEST(GrowthWatch, PowersOfTimeAreNot) {
  for (const double p : {2.0, 4.0, 10.0, 20.0}) {
    const Motion rocket{[p](double t) { return 1e-9 * std::pow(t, p); }, [](double t) { return t * t; }};
    EXPECT_EQ(watch(rocket, 1e6, 100.0).first, "") << p;
    EXPECT_EQ(watch(rocket, 100.0, 0.01).first, "") << p;
  }
}

// An inverted pendulum falls from round-off through 30 factors of ten and goes round for ever.
TEST(GrowthWatch, WhatFallsOverIsNot) {
  const Motion pendulum{[](double t) { return std::min(1e-30 * std::exp(6.0 * t), 20.0 + std::sin(t)); },
                        [](double t) { return std::min(1e-15 * std::exp(3.0 * t), 6.28 + 5.0 * t); }};
  EXPECT_EQ(watch(pendulum, 1e4, 0.1).first, "");
}

// A shot: from rest to full speed between two rows, then far away.
TEST(GrowthWatch, ASuddenKickIsNot) {
  const Motion shot{[](double t) { return t < 1.0 ? 1e-20 : 1e4; },
                    [](double t) { return t < 1.0 ? 0.0 : 2e3 * t; }};
  EXPECT_EQ(watch(shot, 100.0, 0.1).first, "");
}

// No loop over the decades on the way to infinity.
TEST(GrowthWatch, AnEnergyBeyondAllNumbersEndsTheRun) {
  for (const double energy :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    GrowthWatch watch;
    watch.observe(0.0, 1.0, 0.0, 0.0);
    watch.observe(1.0, energy, 0.0, 0.0);
    EXPECT_THAT(watch.reason(), ::testing::HasSubstr("beyond all numbers"));
  }
}

TEST(GrowthWatch, AWayFromLightSpeedNewtonEnds) {
  GrowthWatch watch;
  watch.observe(0.0, 1.0, 0.0, 2.9e7);
  EXPECT_EQ(watch.reason(), "");
  watch.observe(1.0, 1.0, 0.0, 3.1e7);
  EXPECT_THAT(watch.reason(), HasSubstr("speed of light"));
}

// Of a run that has to stop: seven factors of ten in equal times within one metre; under a force that has a bound (t^2) they take longer and longer.
TEST(GrowthWatch, IsSuspectedWhereTheEnergyGrowsInEqualTimes) {
  GrowthWatch exponential, bounded;
  for (int i = 0; i <= 8; ++i) {
    exponential.observe(0.1 * i, std::pow(10.0, i), 1.0, 0.0);
    bounded.observe(std::pow(10.0, 0.5 * i), std::pow(10.0, i), 1.0, 0.0);
  }
  EXPECT_NE(exponential.suspicion(), "");
  EXPECT_EQ(bounded.suspicion(), "");
  EXPECT_EQ(exponential.reason(), "");
}

}  // namespace
}  // namespace flexura::mbs::test
