// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/library/accuracy_goal.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace flexura::reduce {
namespace {

std::vector<MeshShare::Mode> modes(const std::vector<std::pair<double, double>>& omega_and_error) {
  std::vector<MeshShare::Mode> out;
  for (const auto& [omega, error] : omega_and_error) out.push_back({omega * omega, error});
  return out;
}

// 99 may fall to 99 (1 - 3 x 0.1 %) = 98.7, 103 to 103 (1 - 3 x 2 %) = 96.8, below 99 and 100, and 100 to 99.7; 200 stays
// above all of them.
TEST(SaidOfFrequency, IsThatOfTheWorstThatMayHaveChangedPlaces) {
  const auto three = modes({{99.0, 0.001}, {100.0, 0.001}, {103.0, 0.02}, {200.0, 0.05}});
  EXPECT_EQ(said_of_frequency(three, 0, 3.0), 0.02);
  EXPECT_EQ(said_of_frequency(three, 1, 3.0), 0.02);
  EXPECT_EQ(said_of_frequency(three, 2, 3.0), 0.02);
  EXPECT_EQ(said_of_frequency(three, 3, 3.0), 0.05);
  // With estimates that hold, 103 falls to 100.9 and meets none.
  EXPECT_EQ(said_of_frequency(three, 0, 1.0), 0.001);
  EXPECT_EQ(said_of_frequency(three, 1, 1.0), 0.001);
}

TEST(SaidOfFrequency, TakesNoneThatTheMeshDoesNotResolve) {
  const double unknown = std::numeric_limits<double>::infinity();
  const auto two = modes({{10.0, 0.001}, {50.0, unknown}});
  EXPECT_EQ(said_of_frequency(two, 0, 3.0), 0.001);
  EXPECT_EQ(said_of_frequency(two, 1, 3.0), unknown);
}

}  // namespace
}  // namespace flexura::reduce
