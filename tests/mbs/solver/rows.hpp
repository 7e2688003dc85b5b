// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "mbs/solver/run/run.hpp"

namespace flexura::mbs::test {

/// All that a run gives away.
struct Rows {
  std::vector<State> states;
  std::vector<Eigen::VectorXd> v_dot;
  std::vector<double> energy_errors;

  /// Callbacks that add to these rows.
  RunCallbacks callbacks() {
    RunCallbacks out;
    out.row = [this](const State& s, const Eigen::VectorXd& a, const EnergyAccount& energy) {
      states.push_back(s);
      v_dot.push_back(a);
      energy_errors.push_back(energy.error());
    };
    return out;
  }
};

inline void expect_same_to_the_bit(const Rows& a, const Rows& b) {
  ASSERT_EQ(a.states.size(), b.states.size());
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    EXPECT_EQ(a.states[i].t, b.states[i].t);
    EXPECT_EQ(a.states[i].p, b.states[i].p) << i;
    EXPECT_EQ(a.states[i].v, b.states[i].v) << i;
    EXPECT_EQ(a.states[i].lambda, b.states[i].lambda) << i;
    EXPECT_EQ(a.v_dot[i], b.v_dot[i]) << i;
    EXPECT_EQ(a.energy_errors[i], b.energy_errors[i]) << i;
  }
}

}  // namespace flexura::mbs::test
