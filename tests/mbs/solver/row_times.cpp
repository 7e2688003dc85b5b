// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/row_times.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace flexura::mbs {
namespace {

std::vector<double> rows_behind_start(double start, double end, double apart) {
  SolverOptions options;
  options.start_time = start;
  options.end_time = end;
  options.output_step = apart;
  RowTimes times(options, {});
  std::vector<double> out;
  while (times.is_row_until(end)) out.push_back(times.take_row());
  return out;
}

// A run that goes on from one of its rows: 0.172 + 357 * 0.004 is a round-off before 1.6, and was a row beside that of the
// end.  From each row of this run there are as many more as there were in it, the last at its end.
TEST(RowTimes, EndOnceHoweverTheyRound) {
  constexpr double end = 1.6, apart = 0.004;
  for (int k = 0; k < 400; ++k) {
    const std::vector<double> rows = rows_behind_start(k * apart, end, apart);
    ASSERT_EQ(rows.size(), static_cast<std::size_t>(400 - k)) << k;
    EXPECT_EQ(rows.back(), end) << k;
  }
}

TEST(RowTimes, EndAtTheEndWhereTheStepDoesNotDivideTheRun) {
  EXPECT_EQ(rows_behind_start(0.0, 1.0, 0.3), (std::vector<double>{0.3, 2 * 0.3, 3 * 0.3, 1.0}));
}

}  // namespace
}  // namespace flexura::mbs
