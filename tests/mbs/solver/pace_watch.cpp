// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/watch/pace_watch.hpp"

#include <gtest/gtest.h>

namespace flexura::mbs {
namespace {

SolverOptions ten_seconds() {
  SolverOptions options;
  options.end_time = 10.0;
  return options;
}

// Windows that crept when so many steps of that length were taken.
int windows_after(PaceWatch& watch, int steps, double& t, double h) {
  for (int k = 0; k < steps; ++k) watch.step(t += h);
  return watch.windows();
}

TEST(PaceWatch, StepsOfWhichABillionDoNotReachTheEndCreep) {
  PaceWatch watch(ten_seconds());
  double t = 0.0;
  EXPECT_EQ(windows_after(watch, 20000, t, 2e-8), 0);  // 5e8 of them would
  EXPECT_EQ(windows_after(watch, 20000, t, 5e-9), 10);
  EXPECT_NEAR(watch.steps_left(t), 2e9, 1e6);
  // One longer step in between is of no use, a second of motion is.
  EXPECT_EQ(windows_after(watch, 2000, t += 1e-9, 5e-9), 11);
  EXPECT_EQ(windows_after(watch, 2000, t += 1.0, 5e-9), 0);
}

// A vibration of 10 MHz that dies away within thousands of steps.
TEST(PaceWatch, StepsThatGetLongerDoNotCreepForGood) {
  PaceWatch watch(ten_seconds());
  double t = 0.0;
  for (double h = 1e-9; h < 9e-9; h *= 1.5) EXPECT_LE(windows_after(watch, 2000, t, h), 3) << h;
}

TEST(PaceWatch, StepsThatWereAskedForDoNotCreep) {
  SolverOptions options = ten_seconds();
  options.fixed_step = 1e-9;
  PaceWatch watch(options);
  double t = 0.0;
  EXPECT_EQ(windows_after(watch, 20000, t, 1e-9), 0);
}

}  // namespace
}  // namespace flexura::mbs
